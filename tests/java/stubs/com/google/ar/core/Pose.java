package com.google.ar.core;

public class Pose {
  public float[] getTranslation() {
    return new float[3];
  }

  public float[] getRotationQuaternion() {
    return new float[4];
  }

  public void toMatrix(float[] destination, int offset) {}
}
