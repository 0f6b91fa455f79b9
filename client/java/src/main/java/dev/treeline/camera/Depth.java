package dev.treeline.camera;

import dev.treeline.geometry.RigidTransform;

/**
 * Depth along the optical axis (not along the ray), and how it lies to the
 * colour picture. The values 0 and 65535 mean "not measured".
 */
public final class Depth {
  /** How depth pixels relate to colour pixels. */
  public enum Registration {
    /** A depth pixel sees what the colour pixel at its place sees. */
    REGISTERED_TO_COLOR,
    /** Straight from the depth camera that the scene was recorded with. */
    SCENE_CALIBRATION,
    /** Straight from {@link Depth#camera}. */
    OWN_CAMERA
  }

  private static final int BYTES_PER_VALUE = 2;

  /** A 16-bit PNG file; null: there are raw values. */
  final byte[] png;
  /** Little-endian, rows from the top; null: there is a PNG file. */
  final byte[] raw;
  /** Of the raw values, else 0. */
  public final int widthPx;
  /** Of the raw values, else 0. */
  public final int heightPx;
  /** Metres per unit of a value: 0.001 for millimetres. */
  public final double unitM;
  /** Whose view it is. */
  public final Registration registration;
  /** Of OWN_CAMERA, else null. */
  public final Camera camera;
  /** Of OWN_CAMERA, else null. */
  public final RigidTransform colorFromDepth;
  /** World units per measured metre; 0: not stated, which is 1. */
  public final double depthScale;

  private Depth(byte[] png, byte[] raw, int widthPx, int heightPx,
      double unitM, Registration registration, Camera camera,
      RigidTransform colorFromDepth, double depthScale) {
    this.png = png;
    this.raw = raw;
    this.widthPx = widthPx;
    this.heightPx = heightPx;
    this.unitM = unitM;
    this.registration = registration;
    this.camera = camera;
    this.colorFromDepth = colorFromDepth;
    this.depthScale = depthScale;
  }

  /**
   * A 16-bit PNG file, of the colour picture's size and view.
   *
   * @param file its bytes, which are not copied
   * @param unitM metres per unit of a value
   * @return registered to colour
   */
  public static Depth ofPng(byte[] file, double unitM) {
    return new Depth(file, null, 0, 0, unitM,
        Registration.REGISTERED_TO_COLOR, null, null, 0);
  }

  /**
   * Raw values, of the colour picture's size and view.
   *
   * @param values width * height of them, unsigned, rows from the top
   * @param widthPx of the rows
   * @param heightPx how many rows
   * @param unitM metres per unit of a value
   * @return registered to colour
   * @throws IllegalArgumentException if there are more or fewer values
   */
  public static Depth ofValues(
      short[] values, int widthPx, int heightPx, double unitM) {
    if (values.length != widthPx * heightPx) {
      throw new IllegalArgumentException(values.length + " values are not "
          + widthPx + "x" + heightPx);
    }
    byte[] raw = new byte[BYTES_PER_VALUE * values.length];
    for (int i = 0; i < values.length; ++i) {
      raw[2 * i] = (byte) values[i];
      raw[2 * i + 1] = (byte) (values[i] >> 8);
    }
    return ofLittleEndian(raw, widthPx, heightPx, unitM);
  }

  static Depth ofLittleEndian(
      byte[] raw, int widthPx, int heightPx, double unitM) {
    return new Depth(null, raw, widthPx, heightPx, unitM,
        Registration.REGISTERED_TO_COLOR, null, null, 0);
  }

  /**
   * The same depth, straight from the camera that the scene was recorded with.
   *
   * @return another one
   */
  public Depth ofSceneCamera() {
    return new Depth(png, raw, widthPx, heightPx, unitM,
        Registration.SCENE_CALIBRATION, null, null, depthScale);
  }

  /**
   * The same depth, straight from a camera of its own.
   *
   * @param depthCamera of the depth image's size
   * @param colorFromDepthCamera maps points of that camera's frame into that of
   *     the colour camera
   * @return another one
   */
  public Depth ofCamera(
      Camera depthCamera, RigidTransform colorFromDepthCamera) {
    return new Depth(png, raw, widthPx, heightPx, unitM,
        Registration.OWN_CAMERA, depthCamera, colorFromDepthCamera, depthScale);
  }

  /**
   * The same depth with a scale; refused by the server with
   * {@link #ofSceneCamera}.
   *
   * @param scale world units per measured metre, in [0.5, 2]
   * @return another one
   */
  public Depth scaled(double scale) {
    return new Depth(png, raw, widthPx, heightPx, unitM, registration, camera,
        colorFromDepth, scale);
  }

  /**
   * The PNG file.
   *
   * @return null: there are raw values
   */
  public byte[] png() {
    return png == null ? null : png.clone();
  }

  /**
   * The raw values, little-endian.
   *
   * @return null: there is a PNG file
   */
  public byte[] raw() {
    return raw == null ? null : raw.clone();
  }
}
