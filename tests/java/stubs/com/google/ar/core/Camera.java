package com.google.ar.core;

public class Camera {
  public TrackingState getTrackingState() {
    return TrackingState.TRACKING;
  }

  public Pose getPose() {
    return new Pose();
  }

  public CameraIntrinsics getImageIntrinsics() {
    return new CameraIntrinsics();
  }

  public CameraIntrinsics getTextureIntrinsics() {
    return new CameraIntrinsics();
  }
}
