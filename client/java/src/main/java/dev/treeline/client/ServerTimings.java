package dev.treeline.client;

/** Where the server's time went, in the order of its stages. */
public final class ServerTimings {
  /** Waiting for a worker. */
  public final double queueMs;
  /** Finding the scene, decoding the picture. */
  public final double decodeMs;
  /** Choosing pixels. */
  public final double sampleMs;
  /** Predicting where they lie. */
  public final double forestMs;
  /** Finding the pose. */
  public final double poseMs;
  /** The last three and what lies between. */
  public final double localizeMs;
  /** From the arrival of the request to its answer. */
  public final double totalMs;

  ServerTimings(double queueMs, double decodeMs, double sampleMs,
      double forestMs, double poseMs, double localizeMs, double totalMs) {
    this.queueMs = queueMs;
    this.decodeMs = decodeMs;
    this.sampleMs = sampleMs;
    this.forestMs = forestMs;
    this.poseMs = poseMs;
    this.localizeMs = localizeMs;
    this.totalMs = totalMs;
  }
}
