package dev.treeline.fusion;

import dev.treeline.geometry.RigidTransform;

/** What is known at the time of a tracked pose. */
public final class DriftEstimate {
  /** Whether anything is. */
  public final DriftState state;
  /** For drawing: smooth. Null while searching or tentative. */
  public final RigidTransform worldFromDevice;
  /** The same for the tracked pose. */
  public final RigidTransform worldFromCamera;
  /** Of worldFromCamera as it is known, to which the drawn one moves: largest
   * standard deviation along an axis of the world. NaN: there is no world. */
  public final double positionSigmaM;
  /** The same about an axis. */
  public final double rotationSigmaDeg;
  /** Since the last fix that the world was built on was captured. NaN: there
   * was none yet. */
  public final double sinceGoodFixS;
  /** Distinct views of the fixes that speak most against the world; counted up
   * to {@link DriftParameters#contradictionViews}. */
  public final int contradictingViews;
  /** Whether worldFromDevice was set at once, not moved. */
  public final boolean snapped;
  /** Whether tracking began anew with this pose, by a gap or a jump. */
  public final boolean trackingBroke;

  DriftEstimate(DriftState state, RigidTransform worldFromDevice,
      RigidTransform worldFromCamera, double positionSigmaM,
      double rotationSigmaDeg, double sinceGoodFixS, int contradictingViews,
      boolean snapped, boolean trackingBroke) {
    this.state = state;
    this.worldFromDevice = worldFromDevice;
    this.worldFromCamera = worldFromCamera;
    this.positionSigmaM = positionSigmaM;
    this.rotationSigmaDeg = rotationSigmaDeg;
    this.sinceGoodFixS = sinceGoodFixS;
    this.contradictingViews = contradictingViews;
    this.snapped = snapped;
    this.trackingBroke = trackingBroke;
  }
}
