package dev.treeline.fusion;

import dev.treeline.geometry.RigidTransform;
import java.util.ArrayList;
import java.util.List;

/** The device's own tracking of the last seconds, and how uncertain it
 * becomes. */
final class TrackHistory {
  static final double NS_PER_S = 1e9;

  private final DriftParameters parameters;
  private final List<TrackedPose> samples = new ArrayList<>();

  TrackHistory(DriftParameters parameters) {
    this.parameters = parameters;
  }

  static double seconds(long fromNs, long toNs) {
    return (toNs - fromNs) / NS_PER_S;
  }

  /** Null: there is none. */
  TrackedPose oldest() {
    return samples.isEmpty() ? null : samples.get(0);
  }

  /** Null: there is none. */
  TrackedPose newest() {
    return samples.isEmpty() ? null : samples.get(samples.size() - 1);
  }

  void clear() {
    samples.clear();
  }

  /** Whether a sample cannot be the continuation of what came before. */
  boolean isBroken(long timeNs, RigidTransform deviceFromCamera) {
    TrackedPose last = newest();
    if (last == null) return false;
    double passedS = seconds(last.timeNs, timeNs);
    return passedS > parameters.maxGapS
        || last.distanceToM(deviceFromCamera)
            > parameters.maxSpeedMps * passedS
        || last.angleToRad(deviceFromCamera)
            > Math.toRadians(parameters.maxTurnDegps) * passedS;
  }

  /** A sample later than all others. */
  TrackedPose add(long timeNs, RigidTransform deviceFromCamera) {
    TrackedPose last = newest();
    TrackedPose sample = last == null
        ? new TrackedPose(timeNs, deviceFromCamera, 0, 0)
        : new TrackedPose(timeNs, deviceFromCamera,
            last.movedM + last.distanceToM(deviceFromCamera),
            last.turnedRad + last.angleToRad(deviceFromCamera));
    samples.add(sample);
    int first = 0;
    while (seconds(samples.get(first).timeNs, timeNs) > parameters.historyS) {
      ++first;
    }
    samples.subList(0, first).clear();
    return sample;
  }

  /** Where the camera was; null before the first and after the last. */
  TrackedPose at(long timeNs) {
    int next = 0;
    while (next < samples.size() && samples.get(next).timeNs < timeNs) ++next;
    if (next == samples.size()) return null;
    TrackedPose after = samples.get(next);
    if (after.timeNs == timeNs) return after;
    if (next == 0) return null;
    TrackedPose before = samples.get(next - 1);
    double t = seconds(before.timeNs, timeNs)
        / seconds(before.timeNs, after.timeNs);
    return new TrackedPose(timeNs,
        before.deviceFromCamera.interpolate(after.deviceFromCamera, t),
        before.movedM + t * (after.movedM - before.movedM),
        before.turnedRad + t * (after.turnedRad - before.turnedRad));
  }

  /** Covariance of the drift between two moments: it grows with the way. */
  double[] drift(TrackedPose from, TrackedPose to) {
    double movedM = to.movedM - from.movedM;
    double turnedRad = to.turnedRad - from.turnedRad;
    double passedS = seconds(from.timeNs, to.timeNs);
    DriftParameters p = parameters;
    return GaussianPose.diagonal(
        square(p.driftMPerSqrtM) * movedM + square(p.driftMPerSqrtS) * passedS,
        square(Math.toRadians(p.driftDegPerSqrtM)) * movedM
            + square(Math.toRadians(p.driftDegPerSqrtRad)) * turnedRad
            + square(Math.toRadians(p.driftDegPerSqrtS)) * passedS);
  }

  static double square(double value) {
    return value * value;
  }
}
