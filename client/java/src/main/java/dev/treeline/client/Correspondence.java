package dev.treeline.client;

import dev.treeline.geometry.Vector3;


/** One sample that supported or contradicted the answer. */
public final class Correspondence {
  /** The centre of the top left pixel is (0, 0). */
  public final double xPx;
  /** Downwards. */
  public final double yPx;
  /** Measured. */
  public final Vector3 pointInCameraM;
  /** As the model predicted it. */
  public final Vector3 pointInWorldM;
  /** Whether the pose explains it. */
  public final boolean inlier;

  Correspondence(double xPx, double yPx, Vector3 pointInCameraM,
      Vector3 pointInWorldM, boolean inlier) {
    this.xPx = xPx;
    this.yPx = yPx;
    this.pointInCameraM = pointInCameraM;
    this.pointInWorldM = pointInWorldM;
    this.inlier = inlier;
  }
}
