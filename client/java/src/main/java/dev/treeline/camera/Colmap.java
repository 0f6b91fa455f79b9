package dev.treeline.camera;

import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;

/**
 * COLMAP. Models, names and the order of parameters are Treeline's. COLMAP puts
 * the centre of the top left pixel at (0.5, 0.5), Treeline at (0, 0).
 */
public final class Colmap {
  private Colmap() {}

  /**
   * The camera of a line of cameras.txt: half a pixel is subtracted from cx and
   * cy.
   *
   * @param model its name
   * @param widthPx of the picture
   * @param heightPx of the picture
   * @param parameters as they are in the line
   * @return of the same model
   */
  public static Camera camera(
      String model, int widthPx, int heightPx, double... parameters) {
    return new Camera(model, widthPx, heightPx, parameters)
        .withCentreMoved(-0.5, -0.5);
  }

  /**
   * The parameters for cameras.txt, and for the GeoPose Protocol.
   *
   * @param camera with Treeline's pixels
   * @return with half a pixel added to cx and cy
   */
  public static double[] parameters(Camera camera) {
    return camera.withCentreMoved(0.5, 0.5).parameters();
  }

  /**
   * The pose of a line of images.txt, QW QX QY QZ TX TY TZ, which maps points
   * of the world into the camera.
   *
   * @param qw the rotation's real part
   * @param qx of i
   * @param qy of j
   * @param qz of k
   * @param translationM TX, TY and TZ
   * @return worldFromCamera
   */
  public static RigidTransform worldFromCamera(double qw, double qx, double qy,
      double qz, Vector3 translationM) {
    return new RigidTransform(
        new Quaternion(qw, qx, qy, qz).normalized(), translationM).inverse();
  }
}
