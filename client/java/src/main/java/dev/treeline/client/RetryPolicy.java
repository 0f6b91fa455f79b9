package dev.treeline.client;

/** How often and how soon a call is made again. */
public final class RetryPolicy {
  /** Four attempts, after 50 ms and more. */
  public static final RetryPolicy DEFAULT = new RetryPolicy(4, 50, 1000, 3);
  /** One attempt. */
  public static final RetryPolicy NEVER = new RetryPolicy(1, 50, 1000, 3);

  /** Attempts of one call in all, over all servers. */
  public final int maxAttempts;
  /** Before the second attempt; the next ones wait multiplier times as long,
   * and each between half of it and all of it. */
  public final long firstBackoffMs;
  /** No wait is longer, but for servers that ask for it. */
  public final long maxBackoffMs;
  /** Of one wait over the one before. */
  public final double multiplier;

  /**
   * A policy of its numbers.
   *
   * @param maxAttempts at least 1
   * @param firstBackoffMs before the second attempt
   * @param maxBackoffMs of the longest wait
   * @param multiplier of one wait over the one before
   */
  public RetryPolicy(int maxAttempts, long firstBackoffMs, long maxBackoffMs,
      double multiplier) {
    if (maxAttempts < 1) {
      throw new IllegalArgumentException(
          "maxAttempts: " + maxAttempts + " is not at least 1");
    }
    this.maxAttempts = maxAttempts;
    this.firstBackoffMs = firstBackoffMs;
    this.maxBackoffMs = maxBackoffMs;
    this.multiplier = multiplier;
  }

  // Never less than the server asks for; a little more, so that clients that
  // were turned away together do not come back together. chance: in [0, 1).
  long pauseMs(TreelineException error, int tried, double chance) {
    if (error.retryAfterMs >= 0) {
      return (long) Math.ceil(error.retryAfterMs * (1 + chance / 10));
    }
    double backoffMs = Math.min(
        maxBackoffMs, firstBackoffMs * Math.pow(multiplier, tried - 1));
    return (long) Math.ceil(backoffMs * (1 + chance) / 2);
  }

  // UNAVAILABLE says that the call was not begun, or that it does no harm to
  // ask again. RESOURCE_EXHAUSTED is also said of messages that are too large:
  // only with a time to wait is there sense in it.
  static boolean isWorthRetrying(TreelineException error) {
    return error.code == ErrorCode.UNAVAILABLE
        || (error.code == ErrorCode.RESOURCE_EXHAUSTED
            && error.retryAfterMs >= 0);
  }
}
