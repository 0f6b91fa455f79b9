package dev.treeline.camera;

import static org.junit.Assert.assertArrayEquals;
import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertThrows;

import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import org.junit.Test;

public class CameraTest {
  private static final double ROUNDING = 1e-12;
  // Of what ARCore has as float.
  private static final double FLOAT_ROUNDING = 1e-6;
  private static final float S = (float) Math.sqrt(0.5);

  private static void assertNear(
      Vector3 actual, double x, double y, double z, double tolerance) {
    assertEquals(actual + " is not " + new Vector3(x, y, z), 0,
        actual.minus(new Vector3(x, y, z)).norm(), tolerance);
  }

  private static double[] project(Camera camera, double x, double y, double z) {
    double[] p = camera.parameters();
    return new double[] {p[0] * x / z + p[2], p[1] * y / z + p[3]};
  }

  @Test
  public void arCoreGivesXyzwAndOpenGlAxes() {
    Camera camera = ArCore.camera(new float[] {500, 510},
        new float[] {320, 240}, new int[] {640, 480});
    // 500 * 0.1 + 319.5, 510 * 0.1 + 239.5.
    assertArrayEquals(
        new double[] {369.5, 290.5}, project(camera, 1, 1, 10), ROUNDING);
    // At (1, 2, 3), turned by 90 degrees about y: an OpenGL camera that looks
    // along -z of it looks to (-1, 0, 0) of the world.
    RigidTransform deviceFromCamera = ArCore.deviceFromCamera(
        new float[] {1, 2, 3}, new float[] {0, S, 0, S});
    assertNear(deviceFromCamera.transform(new Vector3(0, 0, 5)), -4, 2, 3,
        FLOAT_ROUNDING);
    // What is below in the picture is below in the world.
    assertNear(deviceFromCamera.transform(new Vector3(0, 1, 0)), 1, 1, 3,
        FLOAT_ROUNDING);
    // The same pose as Pose.toMatrix has it.
    RigidTransform ofMatrix = ArCore.deviceFromCamera(
        new float[] {0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 2, 3, 1});
    assertNear(ofMatrix.transform(new Vector3(1, 0, 0)), 1, 2, 2, ROUNDING);
    assertEquals(0, ofMatrix.rotation.angleToRad(deviceFromCamera.rotation),
        FLOAT_ROUNDING);
    assertThrows(IllegalArgumentException.class, () -> ArCore.deviceFromCamera(
        new float[] {1, 2, 3}, new float[] {0, 0, 1}));
  }

  @Test
  public void gravityPointsToTheLeftOfAPictureWhoseRightSideIsUp() {
    RigidTransform upright =
        OpenGlAxes.fromOpenGlCamera(RigidTransform.IDENTITY);
    assertNear(Camera.gravityInCameraMps2(upright), 0, 9.81, 0, ROUNDING);
    // The camera's x axis upwards: turned by +90 degrees about OpenGL's z, as a
    // phone that is held upright turns its landscape sensor.
    RigidTransform turned = OpenGlAxes.fromOpenGlCamera(new RigidTransform(
        Quaternion.fromAxisAngle(new Vector3(0, 0, Math.PI / 2)),
        Vector3.ZERO));
    assertNear(Camera.gravityInCameraMps2(turned), -9.81, 0, 0, ROUNDING);
    assertNear(OpenGlAxes.toOpenGlCamera(turned)
        .transform(new Vector3(1, 0, 0)), 0, 1, 0, ROUNDING);
  }

  @Test
  public void openCvPixelsAreTreelinePixels() {
    double[] matrix = {525, 0, 319.5, 0, 530, 239.5, 0, 0, 1};
    Camera camera = OpenCv.camera(matrix, 640, 480);
    assertEquals(Camera.pinhole(640, 480, 525, 530, 319.5, 239.5), camera);
    assertEquals(new Camera("OPENCV", 640, 480,
        525, 530, 319.5, 239.5, 0.1, 0.2, 0.3, 0.4),
        OpenCv.camera(matrix, 640, 480, 0.1, 0.2, 0.3, 0.4));
    assertEquals(new Camera("FULL_OPENCV", 640, 480,
        525, 530, 319.5, 239.5, 0.1, 0.2, 0.3, 0.4, 0.5, 0, 0, 0),
        OpenCv.camera(matrix, 640, 480, 0.1, 0.2, 0.3, 0.4, 0.5));
    assertThrows(IllegalArgumentException.class,
        () -> OpenCv.camera(matrix, 640, 480, 1, 2, 3));
  }

  @Test
  public void solvePnpMapsTheWorldIntoTheCamera() {
    // The camera stands at x = 4 and looks along the world's -x.
    RigidTransform worldFromCamera = OpenCv.worldFromCamera(
        new Vector3(0, Math.PI / 2, 0), new Vector3(0, 0, 4));
    assertNear(worldFromCamera.transform(Vector3.ZERO), 4, 0, 0, ROUNDING);
    assertNear(worldFromCamera.transform(new Vector3(0, 0, 3)), 1, 0, 0,
        ROUNDING);
  }

  @Test
  public void colmapCountsFromTheCorner() {
    Camera camera = Colmap.camera("SIMPLE_RADIAL", 640, 480,
        500, 320, 240, 0.01);
    assertArrayEquals(new double[] {500, 319.5, 239.5, 0.01},
        camera.parameters(), 0);
    assertArrayEquals(new double[] {500, 320, 240, 0.01},
        Colmap.parameters(camera), 0);
    assertNear(Colmap.worldFromCamera(S, 0, S, 0, new Vector3(0, 0, 4))
        .transform(new Vector3(0, 0, 3)), 1, 0, 0, FLOAT_ROUNDING);
    assertThrows(IllegalArgumentException.class,
        () -> Colmap.camera("PINHOLE", 640, 480, 500, 320, 240));
  }

  @Test
  public void edgesStayEdgesWhenAPictureIsMadeSmaller() {
    // 12 megapixels.
    Camera camera = Camera.pinhole(4000, 3000, 3000, 3000, 1999.5, 1499.5);
    assertArrayEquals(new double[] {750, 750, 499.5, 374.5},
        camera.resized(1000, 750).parameters(), 1e-9);
    assertThrows(IllegalArgumentException.class,
        () -> Colmap.camera("SIMPLE_PINHOLE", 640, 480, 500, 320, 240)
            .resized(320, 480));
    assertEquals(
        Camera.pinhole(800, 600, 3000, 3000, 1899.5, 1449.5),
        camera.cropped(100, 50, 800, 600));
  }

  @Test
  public void depthOfArCoreIsPackedAndHasItsOwnCamera() {
    // 3 x 2 values in rows of 8 bytes, after 2 bytes of something else.
    ByteBuffer plane =
        ByteBuffer.allocateDirect(16).order(ByteOrder.LITTLE_ENDIAN);
    short[] values = {1, 2000, (short) 40000, 0, 5, (short) 65535};
    plane.putShort(0, (short) 77);
    for (int i = 0; i < 6; ++i) {
      plane.putShort(2 + 8 * (i / 3) + 2 * (i % 3), values[i]);
    }
    plane.position(2);
    Camera texture = Camera.pinhole(1920, 1280, 1500, 1500, 959.5, 639.5);
    Depth depth = ArCore.depth(plane, 8, 3, 2, texture);
    assertArrayEquals(new byte[] {1, 0, (byte) 0xd0, 7, 0x40, (byte) 0x9c,
        0, 0, 5, 0, (byte) 0xff, (byte) 0xff}, depth.raw());
    assertArrayEquals(
        Depth.ofValues(values, 3, 2, 0.001).raw(), depth.raw());
    assertEquals(0.001, depth.unitM, 0);
    assertEquals(Depth.Registration.OWN_CAMERA, depth.registration);
    assertEquals(texture.resized(3, 2), depth.camera);
    assertEquals(RigidTransform.IDENTITY, depth.colorFromDepth);
    // It was only read.
    assertEquals(2, plane.position());
    assertThrows(IllegalArgumentException.class,
        () -> ArCore.depth(plane, 8, 3, 3, texture));
    assertThrows(IllegalArgumentException.class,
        () -> ArCore.depth(plane, 4, 3, 2, texture));
    assertThrows(IllegalArgumentException.class,
        () -> Depth.ofValues(values, 3, 3, 0.001));
  }

  @Test
  public void planesOfAnyStrideBecomeNv21() {
    byte[] expected = {1, 2, 3, 4, 5, 6, 7, 8, 21, 11, 22, 12};
    // Planar: rows of 6 and of 3 bytes.
    assertArrayEquals(expected, ArCore.nv21(
        ByteBuffer.wrap(new byte[] {1, 2, 3, 4, 0, 0, 5, 6, 7, 8}), 6,
        ByteBuffer.wrap(new byte[] {11, 12, 0}),
        ByteBuffer.wrap(new byte[] {21, 22, 0}), 3, 1, 4, 2));
    // Interleaved, as phones have it: u and v are views of one array, each
    // without the other's last byte.
    byte[] shared = {21, 11, 22, 12};
    assertArrayEquals(expected, ArCore.nv21(
        ByteBuffer.wrap(new byte[] {1, 2, 3, 4, 5, 6, 7, 8}), 4,
        ByteBuffer.wrap(shared, 1, 3), ByteBuffer.wrap(shared, 0, 3), 4, 2,
        4, 2));
    assertThrows(IllegalArgumentException.class, () -> ArCore.nv21(
        ByteBuffer.allocate(7), 4, ByteBuffer.allocate(2),
        ByteBuffer.allocate(2), 2, 1, 4, 2));
    assertThrows(IllegalArgumentException.class, () -> ArCore.nv21(
        ByteBuffer.allocate(9), 3, ByteBuffer.allocate(4),
        ByteBuffer.allocate(4), 2, 1, 3, 3));
  }
}
