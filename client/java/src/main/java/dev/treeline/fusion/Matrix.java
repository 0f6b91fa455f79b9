package dev.treeline.fusion;

/** Small square matrices, row-major, as plain arrays. */
final class Matrix {
  private Matrix() {}

  static double[] sum(double[] a, double[] b) {
    double[] sum = new double[a.length];
    for (int i = 0; i < a.length; ++i) sum[i] = a[i] + b[i];
    return sum;
  }

  static double[] scaled(double[] a, double factor) {
    double[] scaled = new double[a.length];
    for (int i = 0; i < a.length; ++i) scaled[i] = a[i] * factor;
    return scaled;
  }

  /** a * b, of n x n matrices. */
  static double[] product(double[] a, double[] b, int n) {
    double[] product = new double[n * n];
    for (int row = 0; row < n; ++row) {
      for (int column = 0; column < n; ++column) {
        double sum = 0;
        for (int k = 0; k < n; ++k) sum += a[row * n + k] * b[k * n + column];
        product[row * n + column] = sum;
      }
    }
    return product;
  }

  static double[] transposed(double[] a, int n) {
    double[] transposed = new double[n * n];
    for (int i = 0; i < n * n; ++i) transposed[i] = a[(i % n) * n + i / n];
    return transposed;
  }

  /**
   * The lower triangle L of a symmetric positive definite matrix a = L * L^T,
   * or null if a is not positive definite.
   */
  static double[] cholesky(double[] a, int n) {
    double[] l = new double[n * n];
    for (int row = 0; row < n; ++row) {
      for (int column = 0; column <= row; ++column) {
        double sum = a[row * n + column];
        for (int k = 0; k < column; ++k) {
          sum -= l[row * n + k] * l[column * n + k];
        }
        if (row != column) {
          l[row * n + column] = sum / l[column * n + column];
        } else if (sum > 0) {
          l[row * n + row] = Math.sqrt(sum);
        } else {
          return null;
        }
      }
    }
    return l;
  }

  /** The x of L * L^T * x = b. */
  static double[] solveCholesky(double[] l, double[] b) {
    int n = b.length;
    double[] x = b.clone();
    for (int row = 0; row < n; ++row) {
      for (int k = 0; k < row; ++k) x[row] -= l[row * n + k] * x[k];
      x[row] /= l[row * n + row];
    }
    for (int row = n - 1; row >= 0; --row) {
      for (int k = row + 1; k < n; ++k) x[row] -= l[k * n + row] * x[k];
      x[row] /= l[row * n + row];
    }
    return x;
  }

  static double dot(double[] a, double[] b) {
    double sum = 0;
    for (int i = 0; i < a.length; ++i) sum += a[i] * b[i];
    return sum;
  }
}
