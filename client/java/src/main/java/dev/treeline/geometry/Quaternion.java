package dev.treeline.geometry;

/**
 * A rotation as a unit quaternion w + xi + yj + zk, Hamilton's convention.
 * Beware: ARCore's {@code Pose} has the order x, y, z, w.
 */
public final class Quaternion {
  /** No rotation. */
  public static final Quaternion IDENTITY = new Quaternion(1, 0, 0, 0);

  // Below it sin(a/2)/a loses digits: its series is taken.
  private static final double SMALL_ANGLE_RAD = 1e-6;
  private static final double SMALL_SINE = 1e-9;

  /** The real part. */
  public final double w;
  /** Of i. */
  public final double x;
  /** Of j. */
  public final double y;
  /** Of k. */
  public final double z;

  /**
   * A quaternion of its four numbers, which are taken as they are.
   *
   * @param w the real part: first here
   * @param x of i
   * @param y of j
   * @param z of k
   */
  public Quaternion(double w, double x, double y, double z) {
    this.w = w;
    this.x = x;
    this.y = y;
    this.z = z;
  }

  /**
   * The rotation by |axisAngleRad| radians about it: Exp.
   *
   * @param axisAngleRad the axis times the angle
   * @return with norm 1
   */
  public static Quaternion fromAxisAngle(Vector3 axisAngleRad) {
    double angleRad = axisAngleRad.norm();
    double factor = angleRad < SMALL_ANGLE_RAD
        ? 0.5 - angleRad * angleRad / 48 : Math.sin(angleRad / 2) / angleRad;
    return new Quaternion(Math.cos(angleRad / 2), axisAngleRad.x * factor,
        axisAngleRad.y * factor, axisAngleRad.z * factor).normalized();
  }

  /**
   * The rotation of a 3x3 matrix that is orthonormal to rounding, as tracking
   * software gives it.
   *
   * @param rows nine numbers, row by row
   * @return with norm 1
   */
  static Quaternion fromRows(double... rows) {
    double xx = rows[0];
    double yy = rows[4];
    double zz = rows[8];
    double fromX = rows[7] - rows[5];
    double fromY = rows[2] - rows[6];
    double fromZ = rows[3] - rows[1];
    double xy = rows[1] + rows[3];
    double xz = rows[2] + rows[6];
    double yz = rows[5] + rows[7];
    // Four times the squares of w, x, y, z; the largest is divided by.
    double ww4 = 1 + xx + yy + zz;
    double xx4 = 1 + xx - yy - zz;
    double yy4 = 1 - xx + yy - zz;
    double zz4 = 1 - xx - yy + zz;
    double most = Math.max(Math.max(ww4, xx4), Math.max(yy4, zz4));
    if (most == ww4) {
      return new Quaternion(ww4, fromX, fromY, fromZ).normalized();
    }
    if (most == xx4) return new Quaternion(fromX, xx4, xy, xz).normalized();
    if (most == yy4) return new Quaternion(fromY, xy, yy4, yz).normalized();
    return new Quaternion(fromZ, xz, yz, zz4).normalized();
  }

  /**
   * The rotation back.
   *
   * @return the inverse, if the norm is 1
   */
  public Quaternion conjugate() {
    return new Quaternion(w, -x, -y, -z);
  }

  /**
   * The product: first the other, then this.
   *
   * @param b the other
   * @return this * b
   */
  public Quaternion times(Quaternion b) {
    return new Quaternion(w * b.w - x * b.x - y * b.y - z * b.z,
        w * b.x + x * b.w + y * b.z - z * b.y,
        w * b.y - x * b.z + y * b.w + z * b.x,
        w * b.z + x * b.y - y * b.x + z * b.w);
  }

  /**
   * The same rotation with norm 1 and w at least 0.
   *
   * @return NaNs of a quaternion that is 0
   */
  public Quaternion normalized() {
    double length = norm();
    double factor = (w < 0 ? -1 : 1) / length;
    return new Quaternion(w * factor, x * factor, y * factor, z * factor);
  }

  /**
   * The length, 1 for a rotation.
   *
   * @return at least 0
   */
  public double norm() {
    return Math.sqrt(w * w + x * x + y * y + z * z);
  }

  /**
   * The vector turned.
   *
   * @param v in the source frame
   * @return in the target frame
   */
  public Vector3 rotate(Vector3 v) {
    Vector3 q = new Vector3(x, y, z);
    Vector3 twice = q.cross(v).times(2);
    return v.plus(twice.times(w)).plus(q.cross(twice));
  }

  /**
   * The axis times the angle in [0, pi] radians: Log, the inverse of Exp.
   *
   * @return radians
   */
  public Vector3 toAxisAngle() {
    Quaternion q = normalized();
    Vector3 axis = new Vector3(q.x, q.y, q.z);
    double sine = axis.norm();
    if (sine < SMALL_SINE) return axis.times(2);
    return axis.times(2 * Math.atan2(sine, q.w) / sine);
  }

  /**
   * The angle of the rotation that takes this to the other.
   *
   * @param other of the same frames
   * @return in [0, pi] radians
   */
  public double angleToRad(Quaternion other) {
    return other.times(conjugate()).toAxisAngle().norm();
  }

  /**
   * What lies on the shorter arc to the other.
   *
   * @param other of the same frames
   * @param fraction of the way, in [0, 1]
   * @return with norm 1
   */
  public Quaternion slerp(Quaternion other, double fraction) {
    Vector3 whole = other.times(conjugate()).toAxisAngle();
    return fromAxisAngle(whole.times(fraction)).times(this).normalized();
  }

  @Override
  public boolean equals(Object other) {
    if (!(other instanceof Quaternion)) return false;
    Quaternion that = (Quaternion) other;
    return Double.compare(w, that.w) == 0 && Double.compare(x, that.x) == 0
        && Double.compare(y, that.y) == 0 && Double.compare(z, that.z) == 0;
  }

  @Override
  public int hashCode() {
    return 31 * new Vector3(x, y, z).hashCode() + Double.hashCode(w);
  }

  @Override
  public String toString() {
    return w + " + " + x + "i + " + y + "j + " + z + "k";
  }
}
