package dev.treeline.fusion;

import dev.treeline.geometry.RigidTransform;

/** Where the device's tracking had the camera, and how it came there. */
final class TrackedPose {
  final long timeNs;
  final RigidTransform deviceFromCamera;
  /** Since tracking began. */
  final double movedM;
  final double turnedRad;

  TrackedPose(long timeNs, RigidTransform deviceFromCamera, double movedM,
      double turnedRad) {
    this.timeNs = timeNs;
    this.deviceFromCamera = deviceFromCamera;
    this.movedM = movedM;
    this.turnedRad = turnedRad;
  }

  double distanceToM(RigidTransform other) {
    return other.translationM.minus(deviceFromCamera.translationM).norm();
  }

  double angleToRad(RigidTransform other) {
    return deviceFromCamera.rotation.angleToRad(other.rotation);
  }
}
