package dev.treeline.fusion;

import dev.treeline.geometry.RigidTransform;

/**
 * The worldFromDevice that content is drawn with: it follows what is known
 * without steps that people see.
 */
final class ShownWorld {
  private final DriftParameters parameters;
  private RigidTransform worldFromDevice;

  ShownWorld(DriftParameters parameters) {
    this.parameters = parameters;
  }

  /** Null: nothing is known, or the next step sets it at once. */
  RigidTransform current() {
    return worldFromDevice;
  }

  void clear() {
    worldFromDevice = null;
  }

  /**
   * One step of passedS towards worldFromCamera, which is where the camera at
   * deviceFromCamera is known to be. The motion is measured where people see
   * it: at the camera. Returns whether it snapped.
   */
  boolean step(RigidTransform worldFromCamera,
      RigidTransform deviceFromCamera, double passedS) {
    RigidTransform deviceInverse = deviceFromCamera.inverse();
    RigidTransform known = worldFromCamera.times(deviceInverse);
    if (worldFromDevice == null) {
      worldFromDevice = known;
      return true;
    }
    RigidTransform shown = worldFromDevice.times(deviceFromCamera);
    double[] delta = GaussianPose.difference(shown, worldFromCamera);
    double distanceM = GaussianPose.lengthOfTranslationM(delta);
    double angleRad = GaussianPose.angleOfRotationRad(delta);
    DriftParameters p = parameters;
    if (distanceM > p.snapM || angleRad > Math.toRadians(p.snapDeg)) {
      worldFromDevice = known;
      return true;
    }
    // Each for itself: a rotation that waited for a long way would make new
    // errors of position as the camera moves on.
    double move = shareOf(distanceM, p.maxCorrectionMps * passedS);
    double turn = shareOf(
        angleRad, Math.toRadians(p.maxCorrectionDegps) * passedS);
    for (int i = 0; i < delta.length; ++i) delta[i] *= i < 3 ? move : turn;
    worldFromDevice = GaussianPose.moved(shown, delta).times(deviceInverse);
    return false;
  }

  // How much of a length is done, where `most` may be.
  private static double shareOf(double length, double most) {
    return length > most ? most / length : 1;
  }
}
