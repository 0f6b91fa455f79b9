package dev.treeline.geometry;

import static org.junit.Assert.assertArrayEquals;
import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertThrows;
import static org.junit.Assert.assertTrue;

import java.util.Random;
import org.junit.Test;

public class GeometryTest {
  private static final double ROUNDING = 1e-12;
  // Of matrices that are float.
  private static final double FLOAT_ROUNDING = 1e-6;

  private static Quaternion random(Random random) {
    return new Quaternion(random.nextGaussian(), random.nextGaussian(),
        random.nextGaussian(), random.nextGaussian()).normalized();
  }

  @Test
  public void theInverseUndoes() {
    Random random = new Random(1);
    for (int i = 0; i < 100; ++i) {
      RigidTransform a = new RigidTransform(random(random),
          new Vector3(random.nextGaussian(), random.nextGaussian(), 3));
      Vector3 point = new Vector3(1, random.nextGaussian(), -2);
      Vector3 back = a.inverse().transform(a.transform(point));
      assertEquals(0, back.minus(point).norm(), ROUNDING);
      RigidTransform none = a.times(a.inverse());
      assertEquals(0, none.translationM.norm(), ROUNDING);
      assertEquals(0, none.rotation.angleToRad(Quaternion.IDENTITY), ROUNDING);
    }
  }

  @Test
  public void axisAndAngleComeBack() {
    for (double angle : new double[] {0, 1e-9, 1e-4, 1, 3.1}) {
      Vector3 axisAngle = new Vector3(0.6 * angle, 0, -0.8 * angle);
      Vector3 back = Quaternion.fromAxisAngle(axisAngle).toAxisAngle();
      assertEquals(0, back.minus(axisAngle).norm(), ROUNDING);
    }
  }

  @Test
  public void aMatrixIsTheSameTransform() {
    Random random = new Random(2);
    for (int i = 0; i < 200; ++i) {
      RigidTransform a = new RigidTransform(
          random(random), new Vector3(1, 2, 3));
      RigidTransform back = RigidTransform.fromColumnMajor4(a.toColumnMajor4());
      assertEquals(0, back.rotation.angleToRad(a.rotation), FLOAT_ROUNDING);
      assertEquals(a.translationM, back.translationM);
    }
  }

  @Test
  public void halfTurnsHaveNoW() {
    // Each of the four ways of reading a matrix.
    for (Quaternion q : new Quaternion[] {new Quaternion(0, 1, 0, 0),
        new Quaternion(0, 0, 1, 0), new Quaternion(0, 0, 0, 1),
        Quaternion.IDENTITY}) {
      float[] matrix = new RigidTransform(q, Vector3.ZERO).toColumnMajor4();
      assertEquals(q, positive(RigidTransform.fromColumnMajor4(matrix)));
    }
  }

  // -0.0 is another number for equals().
  private static Quaternion positive(RigidTransform a) {
    Quaternion q = a.rotation;
    return new Quaternion(q.w + 0.0, q.x + 0.0, q.y + 0.0, q.z + 0.0);
  }

  @Test
  public void columnsComeFirst() {
    // 90 degrees about z: x goes to y.
    float[] matrix =
        {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1};
    RigidTransform a = RigidTransform.fromColumnMajor4(matrix);
    Vector3 moved = a.transform(new Vector3(1, 0, 0));
    assertEquals(0, moved.minus(new Vector3(4, 6, 6)).norm(), ROUNDING);
    assertArrayEquals(matrix, a.toColumnMajor4(), (float) FLOAT_ROUNDING);
    assertThrows(IllegalArgumentException.class,
        () -> RigidTransform.fromColumnMajor4(new float[9]));
  }

  @Test
  public void theShorterArcIsTaken() {
    RigidTransform a = new RigidTransform(
        Quaternion.fromAxisAngle(new Vector3(0, 0, 0.2)), Vector3.ZERO);
    RigidTransform b = new RigidTransform(
        Quaternion.fromAxisAngle(new Vector3(0, 0, -0.2)),
        new Vector3(2, 0, 0));
    RigidTransform quarter = a.interpolate(b, 0.25);
    assertEquals(0.1, quarter.rotation.toAxisAngle().z, ROUNDING);
    assertEquals(new Vector3(0.5, 0, 0), quarter.translationM);
  }

  @Test
  public void whatIsEqualIsEqual() {
    assertEquals(new Vector3(1, 2, 3), new Vector3(1, 2, 3));
    assertEquals(new Vector3(1, 2, 3).hashCode(),
        new Vector3(1, 2, 3).hashCode());
    assertTrue(!RigidTransform.IDENTITY.equals(new RigidTransform(
        Quaternion.IDENTITY, new Vector3(0, 0, 1))));
  }
}
