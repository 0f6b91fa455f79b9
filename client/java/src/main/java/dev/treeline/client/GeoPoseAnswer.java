package dev.treeline.client;

import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.Vector3;

/** Where the camera was on the Earth: OGC GeoPose 1.0. */
public final class GeoPoseAnswer {
  // x right, y forward, z up from x right, y down, z forward: a quarter turn
  // about x.
  private static final Quaternion GEO_POSE_FROM_CAMERA =
      new Quaternion(Math.sqrt(0.5), -Math.sqrt(0.5), 0, 0);
  private static final double STRAIGHT_UP = 1e-9;

  /** Of the picture, since 1970. */
  public final long captureTimeMs;
  /** To the north. */
  public final double latitudeDeg;
  /** To the east. */
  public final double longitudeDeg;
  /** Above the WGS84 ellipsoid, not above the sea. */
  public final double heightM;
  /** Turns the camera's axes (x right, y down, z forward) into East, North, Up
   * at the camera. The protocol's own quaternion is that of x right, y forward,
   * z up: {@link #enuFromDevice}. */
  public final Quaternion enuFromCamera;
  /** 95 of 100 are within it. */
  public final double positionAccuracyM;
  /** The same of the rotation. */
  public final double orientationAccuracyDeg;

  GeoPoseAnswer(Object json) throws TreelineException {
    captureTimeMs = (long) number(json, "timestamp");
    latitudeDeg = number(json, "geopose", "position", "lat");
    longitudeDeg = number(json, "geopose", "position", "lon");
    heightM = number(json, "geopose", "position", "h");
    Quaternion device = new Quaternion(
        number(json, "geopose", "quaternion", "w"),
        number(json, "geopose", "quaternion", "x"),
        number(json, "geopose", "quaternion", "y"),
        number(json, "geopose", "quaternion", "z"));
    enuFromCamera = device.times(GEO_POSE_FROM_CAMERA).normalized();
    positionAccuracyM = number(json, "accuracy", "position");
    orientationAccuracyDeg = number(json, "accuracy", "orientation");
  }

  /**
   * The rotation of the device's axes, x right, y forward, z up: that of
   * GeoPose's Basic-Quaternion.
   *
   * @return with norm 1
   */
  public Quaternion enuFromDevice() {
    return enuFromCamera.times(GEO_POSE_FROM_CAMERA.conjugate()).normalized();
  }

  /**
   * The same as the angles of GeoPose's Basic-YPR: about the device's z (up),
   * then its new y (forward), then its new x (right), anticlockwise seen from
   * the axis' end. Where the picture's right side points straight up or down,
   * yaw and roll are one; then roll is 0.
   *
   * @return yaw, pitch and roll, degrees
   */
  public double[] yawPitchRollDeg() {
    Quaternion q = enuFromDevice();
    // The device's x axis in East, North, Up.
    Vector3 right = q.rotate(new Vector3(1, 0, 0));
    double level = Math.hypot(right.x, right.y);
    boolean isOne = level < STRAIGHT_UP;
    double yaw =
        isOne ? 2 * Math.atan2(q.z, q.w) : Math.atan2(right.y, right.x);
    double roll = isOne ? 0 : Math.atan2(
        2 * (q.y * q.z + q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y));
    return new double[] {Math.toDegrees(yaw),
        Math.toDegrees(Math.atan2(-right.z, level)), Math.toDegrees(roll)};
  }

  private static double number(Object json, String... path)
      throws TreelineException {
    Object value = Json.at(json, path);
    if (value instanceof Double && Double.isFinite((Double) value)) {
      return (Double) value;
    }
    throw new TreelineException(ErrorCode.INTERNAL,
        "the GeoPose has no number " + String.join(".", path));
  }
}
