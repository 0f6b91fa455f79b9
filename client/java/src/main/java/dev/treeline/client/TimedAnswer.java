package dev.treeline.client;

/** What became of one picture. A failed query ends nothing but itself. */
public final class TimedAnswer {
  /** When it was taken. */
  public final long captureTimeNs;
  /** Pictures that newer ones replaced, since the answer before this one. */
  public final int dropped;
  /** Null: there is an error. */
  public final LocalizeAnswer answer;
  /** Null: there is an answer. */
  public final TreelineException error;

  TimedAnswer(long captureTimeNs, int dropped, LocalizeAnswer answer,
      TreelineException error) {
    this.captureTimeNs = captureTimeNs;
    this.dropped = dropped;
    this.answer = answer;
    this.error = error;
  }
}
