package dev.treeline.geometry;

/**
 * A rigid transform. One is named targetFromSource and maps points of the
 * source frame into the target frame:
 * {@code pointInTarget = rotation * pointInSource + translationM}. In a
 * product, neighbouring names match:
 * {@code worldFromCamera = worldFromDevice.times(deviceFromCamera)}.
 */
public final class RigidTransform {
  /** Maps each point to itself. */
  public static final RigidTransform IDENTITY =
      new RigidTransform(Quaternion.IDENTITY, Vector3.ZERO);

  private static final int MATRIX_ENTRIES = 16;

  /** With norm 1. */
  public final Quaternion rotation;
  /** In the target frame. */
  public final Vector3 translationM;

  /**
   * A transform of its parts.
   *
   * @param rotation with norm 1
   * @param translationM in the target frame
   */
  public RigidTransform(Quaternion rotation, Vector3 translationM) {
    this.rotation = rotation;
    this.translationM = translationM;
  }

  /**
   * The transform of a column-major 4x4 matrix: {@code Pose.toMatrix} of
   * ARCore, what OpenGL takes.
   *
   * @param matrix of targetFromSource, 16 numbers
   * @return targetFromSource
   * @throws IllegalArgumentException if there are not 16
   */
  public static RigidTransform fromColumnMajor4(double[] matrix) {
    if (matrix.length != MATRIX_ENTRIES) {
      throw new IllegalArgumentException(
          "a 4x4 matrix has 16 entries, not " + matrix.length);
    }
    double[] m = matrix;
    return new RigidTransform(
        Quaternion.fromRows(
            m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]),
        new Vector3(m[12], m[13], m[14]));
  }

  /**
   * The same of the floats that Android's matrices have.
   *
   * @param matrix of targetFromSource, 16 numbers
   * @return targetFromSource
   * @throws IllegalArgumentException if there are not 16
   */
  public static RigidTransform fromColumnMajor4(float[] matrix) {
    double[] wide = new double[matrix.length];
    for (int i = 0; i < matrix.length; ++i) wide[i] = matrix[i];
    return fromColumnMajor4(wide);
  }

  /**
   * The column-major 4x4 matrix, as OpenGL and ARCore take it.
   *
   * @return 16 numbers
   */
  public float[] toColumnMajor4() {
    Vector3 x = rotation.rotate(new Vector3(1, 0, 0));
    Vector3 y = rotation.rotate(new Vector3(0, 1, 0));
    Vector3 z = rotation.rotate(new Vector3(0, 0, 1));
    Vector3 t = translationM;
    return new float[] {(float) x.x, (float) x.y, (float) x.z, 0,
        (float) y.x, (float) y.y, (float) y.z, 0,
        (float) z.x, (float) z.y, (float) z.z, 0,
        (float) t.x, (float) t.y, (float) t.z, 1};
  }

  /**
   * The product: first the other, then this.
   *
   * @param b sourceFromOther
   * @return targetFromOther
   */
  public RigidTransform times(RigidTransform b) {
    return new RigidTransform(
        rotation.times(b.rotation).normalized(), transform(b.translationM));
  }

  /**
   * The way back.
   *
   * @return sourceFromTarget
   */
  public RigidTransform inverse() {
    Quaternion back = rotation.conjugate();
    return new RigidTransform(back, back.rotate(translationM).times(-1));
  }

  /**
   * The point in the target frame.
   *
   * @param pointInSourceM in the source frame
   * @return in the target frame
   */
  public Vector3 transform(Vector3 pointInSourceM) {
    return rotation.rotate(pointInSourceM).plus(translationM);
  }

  /**
   * What lies on the way to the other: a line and the shorter arc.
   *
   * @param other of the same frames
   * @param fraction of the way, in [0, 1]
   * @return of the same frames
   */
  public RigidTransform interpolate(RigidTransform other, double fraction) {
    return new RigidTransform(rotation.slerp(other.rotation, fraction),
        translationM.plus(
            other.translationM.minus(translationM).times(fraction)));
  }

  @Override
  public boolean equals(Object other) {
    if (!(other instanceof RigidTransform)) return false;
    RigidTransform that = (RigidTransform) other;
    return rotation.equals(that.rotation)
        && translationM.equals(that.translationM);
  }

  @Override
  public int hashCode() {
    return 31 * rotation.hashCode() + translationM.hashCode();
  }

  @Override
  public String toString() {
    return "rotation " + rotation + ", translation " + translationM + " m";
  }
}
