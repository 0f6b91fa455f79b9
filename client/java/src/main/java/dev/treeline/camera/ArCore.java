package dev.treeline.camera;

import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import java.nio.ByteBuffer;

/**
 * ARCore: the camera, the pose, the picture and the depth of a {@code Frame}.
 * It takes the numbers that ARCore's classes give, not those classes, so that
 * it runs, and is tested, without Android.
 *
 * <p>Take {@code getImageIntrinsics()} with the CPU image
 * ({@code acquireCameraImage()}), and {@code Camera.getPose()}, not
 * {@code getDisplayOrientedPose()}: image, intrinsics and pose then belong to
 * the sensor's pixels, whichever way the phone is held. Of one frame, and with
 * {@code Frame.getTimestamp()} as the time.
 */
public final class ArCore {
  private static final double MILLIMETRE_M = 0.001;
  private static final int BYTES_PER_DEPTH = 2;

  private ArCore() {}

  /**
   * The camera of {@code Camera.getImageIntrinsics()}. ARCore does not say from
   * where it counts the principal point. It is taken to be the picture's top
   * left corner, as in ARKit and in OpenGL: half a pixel is subtracted.
   *
   * @param focalLengthPx of {@code getFocalLength()}
   * @param principalPointPx of {@code getPrincipalPoint()}
   * @param imageDimensionsPx of {@code getImageDimensions()}
   * @return of model PINHOLE
   */
  public static Camera camera(float[] focalLengthPx, float[] principalPointPx,
      int[] imageDimensionsPx) {
    requireLength("focalLengthPx", focalLengthPx.length, 2);
    requireLength("principalPointPx", principalPointPx.length, 2);
    requireLength("imageDimensionsPx", imageDimensionsPx.length, 2);
    return Camera.pinhole(imageDimensionsPx[0], imageDimensionsPx[1],
        focalLengthPx[0], focalLengthPx[1], principalPointPx[0] - 0.5,
        principalPointPx[1] - 0.5);
  }

  /**
   * The pose of {@code Camera.getPose()}. {@code device} is ARCore's world: y
   * up. ARCore may move its world between frames; a jump is for
   * {@code DriftCorrector.trackingReset()}.
   *
   * @param translationM of {@code Pose.getTranslation()}
   * @param rotationXyzw of {@code Pose.getRotationQuaternion()}: qx, qy, qz, qw
   * @return deviceFromCamera
   */
  public static RigidTransform deviceFromCamera(
      float[] translationM, float[] rotationXyzw) {
    requireLength("translationM", translationM.length, 3);
    requireLength("rotationXyzw", rotationXyzw.length, 4);
    return OpenGlAxes.fromOpenGlCamera(new RigidTransform(
        new Quaternion(rotationXyzw[3], rotationXyzw[0], rotationXyzw[1],
            rotationXyzw[2]).normalized(),
        new Vector3(translationM[0], translationM[1], translationM[2])));
  }

  /**
   * The same of the matrix of {@code Pose.toMatrix()}.
   *
   * @param columnMajor 16 numbers
   * @return deviceFromCamera
   */
  public static RigidTransform deviceFromCamera(float[] columnMajor) {
    return OpenGlAxes.fromOpenGlCamera(
        RigidTransform.fromColumnMajor4(columnMajor));
  }

  /**
   * The depth of {@code acquireDepthImage16Bits()} or
   * {@code acquireRawDepthImage16Bits()}: millimetres along the optical axis,
   * of another size than the picture, and of the view of the GPU texture, which
   * may have another aspect ratio than the CPU image. So its camera is that of
   * {@code Camera.getTextureIntrinsics()}, made as small as the depth image;
   * both are views of one camera of the phone, from one place.
   *
   * @param plane of {@code Image.getPlanes()[0].getBuffer()}, which is copied:
   *     the image may be closed afterwards
   * @param rowStrideBytes of {@code getRowStride()}: at least two a pixel
   * @param widthPx of the depth image
   * @param heightPx of the depth image
   * @param textureCamera of {@link #camera} with the texture's intrinsics
   * @return for the query
   * @throws IllegalArgumentException if the plane has not so many rows
   */
  public static Depth depth(ByteBuffer plane, int rowStrideBytes, int widthPx,
      int heightPx, Camera textureCamera) {
    byte[] packed = new byte[BYTES_PER_DEPTH * widthPx * heightPx];
    copyRows("depth", plane, rowStrideBytes, BYTES_PER_DEPTH * widthPx,
        heightPx, packed);
    return Depth.ofLittleEndian(packed, widthPx, heightPx, MILLIMETRE_M)
        .ofCamera(textureCamera.resized(widthPx, heightPx),
            RigidTransform.IDENTITY);
  }

  /**
   * The planes of {@code acquireCameraImage()} (YUV_420_888) as the NV21 that
   * {@code android.graphics.YuvImage} makes a JPEG of, whatever strides the
   * phone has. Each stride is that of the plane: {@code getRowStride()},
   * {@code getPixelStride()}.
   *
   * @param y plane 0
   * @param yRowStrideBytes of plane 0
   * @param u plane 1
   * @param v plane 2
   * @param uvRowStrideBytes of planes 1 and 2
   * @param uvPixelStrideBytes of planes 1 and 2
   * @param widthPx of the picture, even
   * @param heightPx of the picture, even
   * @return width * height * 3 / 2 bytes
   * @throws IllegalArgumentException if a plane has not so many rows, or a side
   *     is odd
   */
  public static byte[] nv21(ByteBuffer y, int yRowStrideBytes, ByteBuffer u,
      ByteBuffer v, int uvRowStrideBytes, int uvPixelStrideBytes, int widthPx,
      int heightPx) {
    if (widthPx % 2 != 0 || heightPx % 2 != 0) {
      throw new IllegalArgumentException(
          widthPx + "x" + heightPx + ": a side is odd");
    }
    int luma = widthPx * heightPx;
    byte[] packed = new byte[luma + luma / 2];
    copyRows("y", y, yRowStrideBytes, widthPx, heightPx, packed);
    int columns = widthPx / 2;
    // The last row of a phone may end with its last sample.
    byte[] row = new byte[(columns - 1) * uvPixelStrideBytes + 1];
    for (int plane = 0; plane < 2; ++plane) {
      ByteBuffer from = (plane == 0 ? v : u).duplicate();
      requireRows(plane == 0 ? "v" : "u", from, uvRowStrideBytes, row.length,
          heightPx / 2);
      int start = from.position();
      for (int r = 0; r < heightPx / 2; ++r) {
        from.position(start + r * uvRowStrideBytes);
        from.get(row);
        int at = luma + r * widthPx + plane;
        for (int c = 0; c < columns; ++c) {
          packed[at + 2 * c] = row[c * uvPixelStrideBytes];
        }
      }
    }
    return packed;
  }

  private static void copyRows(String name, ByteBuffer plane,
      int rowStrideBytes, int rowBytes, int rows, byte[] packed) {
    requireRows(name, plane, rowStrideBytes, rowBytes, rows);
    ByteBuffer from = plane.duplicate();
    int start = from.position();
    for (int row = 0; row < rows; ++row) {
      from.position(start + row * rowStrideBytes);
      from.get(packed, row * rowBytes, rowBytes);
    }
  }

  private static void requireRows(String name, ByteBuffer plane,
      int rowStrideBytes, int rowBytes, int rows) {
    if (rows < 1 || rowStrideBytes < rowBytes
        || plane.remaining() < (rows - 1L) * rowStrideBytes + rowBytes) {
      throw new IllegalArgumentException(name + ": " + plane.remaining()
          + " bytes are not " + rows + " rows of " + rowBytes
          + " bytes, one every " + rowStrideBytes);
    }
  }

  private static void requireLength(String name, int length, int expected) {
    if (length != expected) {
      throw new IllegalArgumentException(
          name + " has " + expected + " numbers, not " + length);
    }
  }
}
