package dev.treeline.camera;

import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import java.util.Arrays;

/**
 * OpenCV. Its camera frame and its pixels are Treeline's: x right, y down, z
 * forward, and the centre of the top left pixel is (0, 0).
 */
public final class OpenCv {
  private static final int MATRIX_ENTRIES = 9;
  private static final int PARAMETERS_OF_FULL = 12;

  private OpenCv() {}

  /**
   * The camera of calibrateCamera().
   *
   * @param cameraMatrix row by row: fx 0 cx 0 fy cy 0 0 1
   * @param widthPx of the picture that was calibrated with
   * @param heightPx of it
   * @param distortion none, or 4, 5 or 8 coefficients: k1, k2, p1, p2, k3, k4,
   *     k5, k6
   * @return PINHOLE, OPENCV or FULL_OPENCV
   * @throws IllegalArgumentException for other models of OpenCV
   */
  public static Camera camera(double[] cameraMatrix, int widthPx, int heightPx,
      double... distortion) {
    if (cameraMatrix.length != MATRIX_ENTRIES) {
      throw new IllegalArgumentException(
          "a 3x3 matrix has 9 entries, not " + cameraMatrix.length);
    }
    double[] pinhole = {cameraMatrix[0], cameraMatrix[4], cameraMatrix[2],
        cameraMatrix[5]};
    int count = distortion.length;
    if (count == 0) return new Camera("PINHOLE", widthPx, heightPx, pinhole);
    if (count != 4 && count != 5 && count != 8) {
      throw new IllegalArgumentException(
          "there is no model with " + count + " distortion coefficients");
    }
    double[] all = Arrays.copyOf(
        pinhole, count == 4 ? pinhole.length + 4 : PARAMETERS_OF_FULL);
    System.arraycopy(distortion, 0, all, pinhole.length, count);
    return new Camera(
        count == 4 ? "OPENCV" : "FULL_OPENCV", widthPx, heightPx, all);
  }

  /**
   * The pose of solvePnP's vectors, which map points of the world into the
   * camera.
   *
   * @param rvecRad the rotation, axis times angle
   * @param tvecM the translation
   * @return worldFromCamera
   */
  public static RigidTransform worldFromCamera(
      Vector3 rvecRad, Vector3 tvecM) {
    return new RigidTransform(Quaternion.fromAxisAngle(rvecRad), tvecM)
        .inverse();
  }
}
