package com.google.ar.core;

public class CameraIntrinsics {
  public float[] getFocalLength() {
    return new float[2];
  }

  public float[] getPrincipalPoint() {
    return new float[2];
  }

  public int[] getImageDimensions() {
    return new int[2];
  }
}
