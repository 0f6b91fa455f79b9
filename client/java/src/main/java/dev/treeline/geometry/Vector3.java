package dev.treeline.geometry;

/**
 * A vector or a point. The name of what holds it says the frame and the unit:
 * {@code pointInWorldM}.
 */
public final class Vector3 {
  /** The origin. */
  public static final Vector3 ZERO = new Vector3(0, 0, 0);

  /** Along x. */
  public final double x;
  /** Along y. */
  public final double y;
  /** Along z. */
  public final double z;

  /**
   * A vector of its three numbers.
   *
   * @param x along x
   * @param y along y
   * @param z along z
   */
  public Vector3(double x, double y, double z) {
    this.x = x;
    this.y = y;
    this.z = z;
  }

  /**
   * The sum.
   *
   * @param other of the same frame
   * @return this + other
   */
  public Vector3 plus(Vector3 other) {
    return new Vector3(x + other.x, y + other.y, z + other.z);
  }

  /**
   * The difference.
   *
   * @param other of the same frame
   * @return this - other
   */
  public Vector3 minus(Vector3 other) {
    return new Vector3(x - other.x, y - other.y, z - other.z);
  }

  /**
   * The multiple.
   *
   * @param factor any number
   * @return this * factor
   */
  public Vector3 times(double factor) {
    return new Vector3(x * factor, y * factor, z * factor);
  }

  /**
   * The cross product.
   *
   * @param other of the same frame
   * @return this x other
   */
  public Vector3 cross(Vector3 other) {
    return new Vector3(y * other.z - z * other.y, z * other.x - x * other.z,
        x * other.y - y * other.x);
  }

  /**
   * The length.
   *
   * @return at least 0
   */
  public double norm() {
    return Math.sqrt(x * x + y * y + z * z);
  }

  @Override
  public boolean equals(Object other) {
    if (!(other instanceof Vector3)) return false;
    Vector3 that = (Vector3) other;
    return Double.compare(x, that.x) == 0 && Double.compare(y, that.y) == 0
        && Double.compare(z, that.z) == 0;
  }

  @Override
  public int hashCode() {
    return 31 * (31 * Double.hashCode(x) + Double.hashCode(y))
        + Double.hashCode(z);
  }

  @Override
  public String toString() {
    return "(" + x + ", " + y + ", " + z + ")";
  }
}
