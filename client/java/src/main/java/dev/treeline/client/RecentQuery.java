package dev.treeline.client;

import dev.treeline.geometry.RigidTransform;


/** What became of a query that somebody made. */
public final class RecentQuery {
  /** When it was answered, ISO 8601. */
  public final String timeUtc;
  /** Null: it was not localized. */
  public final RigidTransform worldFromCamera;
  /** Why not; empty: it was. */
  public final String reason;
  /** Whether the reason is that of an error. */
  public final boolean isError;
  /** In [0, 1]. */
  public final double confidence;
  /** Samples that the pose explains. */
  public final int inliers;
  /** Drawn from the picture. */
  public final int samples;
  /** From arrival to answer. */
  public final double totalMs;

  RecentQuery(String timeUtc, RigidTransform worldFromCamera, String reason,
      boolean isError, double confidence, int inliers, int samples,
      double totalMs) {
    this.timeUtc = timeUtc;
    this.worldFromCamera = worldFromCamera;
    this.reason = reason;
    this.isError = isError;
    this.confidence = confidence;
    this.inliers = inliers;
    this.samples = samples;
    this.totalMs = totalMs;
  }
}
