package dev.treeline.fusion;

import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import java.util.Arrays;

/**
 * A pose worldFromCamera that is known up to a normal distribution: with
 * (translation, rotation) zero-mean of {@link #covariance}, the truth is
 * (Exp(rotation) * rotation of the pose, translation of the pose +
 * translation), both expressed in the world, as docs/frames.md has it.
 */
final class GaussianPose {
  static final int SIZE = 6;
  private static final int ENTRIES = SIZE * SIZE;
  // What rounding does to a covariance, as a share of its largest variance and
  // in m^2 or rad^2: a deviation of 0.03 mm.
  private static final double ROUNDING = 1e-9;

  final RigidTransform worldFromCamera;
  /** Row-major 6x6: x, y, z (m), rotation about x, y, z (rad). */
  final double[] covariance;

  GaussianPose(RigidTransform worldFromCamera, double[] covariance) {
    this.worldFromCamera = worldFromCamera;
    this.covariance = covariance;
  }

  /** diag(v, v, v, r, r, r). */
  static double[] diagonal(
      double positionVarianceM2, double rotationVarianceRad2) {
    double[] matrix = new double[ENTRIES];
    for (int i = 0; i < SIZE; ++i) {
      matrix[7 * i] = i < 3 ? positionVarianceM2 : rotationVarianceRad2;
    }
    return matrix;
  }

  /** Whether it is 6x6, finite, and symmetric and positive semidefinite to
   * rounding. */
  static boolean isCovariance(double[] matrix) {
    if (matrix.length != ENTRIES) return false;
    double largest = 1;
    for (int i = 0; i < ENTRIES; ++i) {
      if (!Double.isFinite(matrix[i])) return false;
      if (i % 7 == 0) largest = Math.max(largest, matrix[i]);
    }
    double tolerance = ROUNDING * largest;
    double[] mirrored = Matrix.transposed(matrix, SIZE);
    for (int i = 0; i < ENTRIES; ++i) {
      if (Math.abs(matrix[i] - mirrored[i]) > tolerance) return false;
    }
    return Matrix.cholesky(
        Matrix.sum(matrix, diagonal(tolerance, tolerance)), SIZE) != null;
  }

  /**
   * The covariance of the same camera after it moved: an error of rotation at
   * the start is an error of position at the end.
   * F * covariance * F^T, F = [I, -[moved]x; 0, I].
   */
  static double[] transported(double[] covariance, Vector3 movedInWorldM) {
    double[] f = diagonal(1, 1);
    f[4] = movedInWorldM.z;
    f[5] = -movedInWorldM.y;
    f[9] = -movedInWorldM.z;
    f[11] = movedInWorldM.x;
    f[15] = movedInWorldM.y;
    f[16] = -movedInWorldM.x;
    return Matrix.product(Matrix.product(f, covariance, SIZE),
        Matrix.transposed(f, SIZE), SIZE);
  }

  /** How pose b differs from a: translation (m), then rotation (rad). */
  static double[] difference(RigidTransform a, RigidTransform b) {
    Vector3 t = b.translationM.minus(a.translationM);
    Vector3 r = b.rotation.times(a.rotation.conjugate()).toAxisAngle();
    return new double[] {t.x, t.y, t.z, r.x, r.y, r.z};
  }

  static double lengthOfTranslationM(double[] delta) {
    return new Vector3(delta[0], delta[1], delta[2]).norm();
  }

  static double angleOfRotationRad(double[] delta) {
    return new Vector3(delta[3], delta[4], delta[5]).norm();
  }

  /** The pose moved by what difference() gives. */
  static RigidTransform moved(RigidTransform pose, double[] delta) {
    return new RigidTransform(
        Quaternion.fromAxisAngle(new Vector3(delta[3], delta[4], delta[5]))
            .times(pose.rotation).normalized(),
        pose.translationM.plus(new Vector3(delta[0], delta[1], delta[2])));
  }

  /** r^T (A + B)^-1 r of the difference r; infinite if A + B is not positive
   * definite. */
  double squaredDistance(GaussianPose other) {
    double[] factor = Matrix.cholesky(
        Matrix.sum(covariance, other.covariance), SIZE);
    if (factor == null) return Double.POSITIVE_INFINITY;
    double[] r = difference(worldFromCamera, other.worldFromCamera);
    return Matrix.dot(r, Matrix.solveCholesky(factor, r));
  }

  /**
   * Both as one: each counts by its information. Gain K = A (A + B)^-1, pose =
   * this moved by K r, covariance = A - K A; A + B is positive definite.
   */
  GaussianPose fused(GaussianPose other) {
    double[] factor = Matrix.cholesky(
        Matrix.sum(covariance, other.covariance), SIZE);
    double[] weighted = Matrix.solveCholesky(
        factor, difference(worldFromCamera, other.worldFromCamera));
    double[] delta = new double[SIZE];
    // Row i: (A + B)^-1 times column i of A, which is symmetric.
    double[][] gains = new double[SIZE][];
    double[][] rows = new double[SIZE][];
    for (int i = 0; i < SIZE; ++i) {
      rows[i] = Arrays.copyOfRange(covariance, SIZE * i, SIZE * (i + 1));
      delta[i] = Matrix.dot(rows[i], weighted);
      gains[i] = Matrix.solveCholesky(factor, rows[i]);
    }
    double[] reduced = new double[ENTRIES];
    for (int i = 0; i < SIZE; ++i) {
      for (int k = 0; k < SIZE; ++k) {
        reduced[SIZE * i + k] =
            rows[i][k] - Matrix.dot(rows[i], gains[k]);
      }
    }
    return new GaussianPose(moved(worldFromCamera, delta), Matrix.scaled(
        Matrix.sum(reduced, Matrix.transposed(reduced, SIZE)), 0.5));
  }

  /** The largest standard deviation along an axis of the world. */
  static double positionSigmaM(double[] covariance) {
    return Math.sqrt(Math.max(
        covariance[0], Math.max(covariance[7], covariance[14])));
  }

  /** The largest standard deviation about an axis of the world. */
  static double rotationSigmaRad(double[] covariance) {
    return Math.sqrt(Math.max(
        covariance[21], Math.max(covariance[28], covariance[35])));
  }
}
