// Small square matrices, row-major, as plain arrays.

export type Matrix = readonly number[];

/** The sum of two matrices, or of two vectors. */
export const addMatrices = (a: Matrix, b: Matrix): number[] =>
  a.map((value, i) => value + b[i]!);

/** a * b, of n x n matrices. */
export function multiplyMatrices(a: Matrix, b: Matrix, n: number): number[] {
  const product = new Array<number>(n * n).fill(0);
  for (let row = 0; row < n; ++row) {
    for (let column = 0; column < n; ++column) {
      let sum = 0;
      for (let k = 0; k < n; ++k) sum += a[row * n + k]! * b[k * n + column]!;
      product[row * n + column] = sum;
    }
  }
  return product;
}

export function transpose(a: Matrix, n: number): number[] {
  return a.map((_, i) => a[(i % n) * n + Math.floor(i / n)]!);
}

/**
 * The lower triangle L of a symmetric positive definite matrix a = L * L^T, or
 * null if a is not positive definite.
 */
export function cholesky(a: Matrix, n: number): number[] | null {
  const l = new Array<number>(n * n).fill(0);
  for (let row = 0; row < n; ++row) {
    for (let column = 0; column <= row; ++column) {
      let sum = a[row * n + column]!;
      for (let k = 0; k < column; ++k) {
        sum -= l[row * n + k]! * l[column * n + k]!;
      }
      if (row !== column) {
        l[row * n + column] = sum / l[column * n + column]!;
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
export function solveCholesky(l: Matrix, b: readonly number[]): number[] {
  const n = b.length;
  const x = [...b];
  for (let row = 0; row < n; ++row) {
    for (let k = 0; k < row; ++k) x[row]! -= l[row * n + k]! * x[k]!;
    x[row]! /= l[row * n + row]!;
  }
  for (let row = n - 1; row >= 0; --row) {
    for (let k = row + 1; k < n; ++k) x[row]! -= l[k * n + row]! * x[k]!;
    x[row]! /= l[row * n + row]!;
  }
  return x;
}
