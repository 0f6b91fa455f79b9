package dev.treeline.camera;

import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import java.util.Arrays;
import java.util.List;

/**
 * Intrinsics of one camera. Its frame: x right, y down, z forward along the
 * optical axis, of the picture as it is sent. Pixels: x right, y down, and the
 * centre of the top left pixel is (0, 0), half a pixel less than what COLMAP
 * writes: see {@link Colmap}. A pinhole camera images pointInCamera at
 * {@code xPx = fxPx * x / z + cxPx, yPx = fyPx * y / z + cyPx}.
 */
public final class Camera {
  private static final List<String> ONE_FOCAL_LENGTH = Arrays.asList(
      "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "SIMPLE_RADIAL_FISHEYE",
      "RADIAL_FISHEYE");
  private static final double GRAVITY_MPS2 = 9.81;
  /** Upwards in the worlds of ARCore, ARKit and WebXR. */
  private static final Vector3 UP_IN_DEVICE = new Vector3(0, 1, 0);

  /** COLMAP's name: PINHOLE, OPENCV and so on. */
  public final String model;
  /** Width of the picture that the parameters belong to. */
  public final int widthPx;
  /** Its height. */
  public final int heightPx;
  private final double[] parameters;

  /**
   * A camera of any model.
   *
   * @param model one of COLMAP's names
   * @param widthPx of the picture that the parameters belong to
   * @param heightPx of it
   * @param parameters in COLMAP's order; cx and cy from the centre of the top
   *     left pixel
   */
  public Camera(String model, int widthPx, int heightPx, double... parameters) {
    this.model = model;
    this.widthPx = widthPx;
    this.heightPx = heightPx;
    this.parameters = parameters.clone();
  }

  /**
   * A camera without distortion.
   *
   * @param widthPx of the picture
   * @param heightPx of the picture
   * @param fxPx focal length along x
   * @param fyPx focal length along y
   * @param cxPx principal point from the centre of the top left pixel
   * @param cyPx the same along y
   * @return of model PINHOLE
   */
  public static Camera pinhole(int widthPx, int heightPx, double fxPx,
      double fyPx, double cxPx, double cyPx) {
    return new Camera("PINHOLE", widthPx, heightPx, fxPx, fyPx, cxPx, cyPx);
  }

  /**
   * The parameters, in COLMAP's order.
   *
   * @return a copy
   */
  public double[] parameters() {
    return parameters.clone();
  }

  /**
   * The camera of the same picture resized as a whole. Edges stay edges:
   * {@code xPx' + 0.5 = (xPx + 0.5) * widthPx' / widthPx}.
   *
   * @param newWidthPx of the resized picture
   * @param newHeightPx of it
   * @return the same model
   * @throws IllegalArgumentException if a model with one focal length is
   *     stretched
   */
  public Camera resized(int newWidthPx, int newHeightPx) {
    double sx = (double) newWidthPx / widthPx;
    double sy = (double) newHeightPx / heightPx;
    int first = focalLengths();
    // Sizes are whole: a ratio that is kept as well as it can be is kept.
    boolean isStretched =
        Math.abs(sx - sy) * Math.max(widthPx, heightPx) > 1;
    if (first == 1 && isStretched) {
      throw new IllegalArgumentException(
          model + " has one focal length and cannot be stretched");
    }
    double[] changed = parameters.clone();
    changed[0] *= sx;
    if (first == 2) changed[1] *= sy;
    changed[first] = (changed[first] + 0.5) * sx - 0.5;
    changed[first + 1] = (changed[first + 1] + 0.5) * sy - 0.5;
    return new Camera(model, newWidthPx, newHeightPx, changed);
  }

  /**
   * The camera of a part of the picture.
   *
   * @param leftPx of the part's top left pixel
   * @param topPx of it
   * @param newWidthPx of the part
   * @param newHeightPx of the part
   * @return the same model
   */
  public Camera cropped(int leftPx, int topPx, int newWidthPx,
      int newHeightPx) {
    return new Camera(model, newWidthPx, newHeightPx,
        withCentreMoved(-leftPx, -topPx).parameters);
  }

  /**
   * The direction in which things fall in the camera's frame, for the query, of
   * a device whose world has y up, as that of ARCore.
   *
   * @param deviceFromCamera see {@link ArCore}
   * @return in the camera's frame
   */
  public static Vector3 gravityInCameraMps2(RigidTransform deviceFromCamera) {
    return gravityInCameraMps2(deviceFromCamera, UP_IN_DEVICE);
  }

  /**
   * The same where another axis is up.
   *
   * @param deviceFromCamera the camera in the device's world
   * @param upInDevice upwards in that world, of length 1
   * @return in the camera's frame
   */
  public static Vector3 gravityInCameraMps2(RigidTransform deviceFromCamera,
      Vector3 upInDevice) {
    return deviceFromCamera.rotation.conjugate().rotate(upInDevice)
        .times(-GRAVITY_MPS2);
  }

  /** The same camera with its principal point moved. */
  Camera withCentreMoved(double dxPx, double dyPx) {
    int first = focalLengths();
    double[] moved = parameters.clone();
    moved[first] += dxPx;
    moved[first + 1] += dyPx;
    return new Camera(model, widthPx, heightPx, moved);
  }

  // How many of the first parameters are focal lengths; the centre follows.
  private int focalLengths() {
    int count = ONE_FOCAL_LENGTH.contains(model) ? 1 : 2;
    if (parameters.length < count + 2) {
      throw new IllegalArgumentException(
          model + " has more than " + parameters.length + " parameters");
    }
    return count;
  }

  @Override
  public boolean equals(Object other) {
    if (!(other instanceof Camera)) return false;
    Camera that = (Camera) other;
    return model.equals(that.model) && widthPx == that.widthPx
        && heightPx == that.heightPx
        && Arrays.equals(parameters, that.parameters);
  }

  @Override
  public int hashCode() {
    return 31 * (31 * model.hashCode() + widthPx) + heightPx
        + Arrays.hashCode(parameters);
  }

  @Override
  public String toString() {
    return model + " " + widthPx + "x" + heightPx + " "
        + Arrays.toString(parameters);
  }
}
