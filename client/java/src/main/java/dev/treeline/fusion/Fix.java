package dev.treeline.fusion;

import dev.treeline.geometry.RigidTransform;

/** What the server says of one picture; {@code LocalizeAnswer.fix} makes it. */
public final class Fix {
  /** When the picture was taken, on the clock of the tracking. */
  public final long captureTimeNs;
  /** Where the camera was. */
  public final RigidTransform worldFromCamera;
  /** In [0, 1]. */
  public final double confidence;
  final double[] covariance;

  /**
   * A fix of its parts.
   *
   * @param captureTimeNs when the picture was taken, on the clock of
   *     {@link DriftCorrector#track}
   * @param worldFromCamera where the camera was
   * @param covariance row-major 6x6, as {@code LocalizeAnswer} has it
   * @param confidence in [0, 1]
   */
  public Fix(long captureTimeNs, RigidTransform worldFromCamera,
      double[] covariance, double confidence) {
    this.captureTimeNs = captureTimeNs;
    this.worldFromCamera = worldFromCamera;
    this.covariance = covariance.clone();
    this.confidence = confidence;
  }
}
