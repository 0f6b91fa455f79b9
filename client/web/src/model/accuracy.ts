// How far from the truth a pose may be, from its covariance.

/** With 95 %, a normal distribution in three dimensions is within this many
 * variances: chi-square, 3 degrees of freedom. */
const CHI_SQUARE_95 = 7.815;

type Symmetric3 = readonly [xx: number, xy: number, xz: number, yy: number,
  yz: number, zz: number];

// The trigonometric solution for symmetric 3x3 matrices.
function largestEigenvalue([xx, xy, xz, yy, yz, zz]: Symmetric3): number {
  const mean = (xx + yy + zz) / 3;
  const a = xx - mean;
  const b = yy - mean;
  const c = zz - mean;
  const spread = Math.sqrt(
      (a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6);
  if (spread === 0) return mean;
  const determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) +
      xz * (xy * yz - b * xz);
  const cosine = determinant / (2 * spread ** 3);
  const angle = Math.acos(Math.min(1, Math.max(-1, cosine))) / 3;
  return mean + 2 * spread * Math.cos(angle);
}

// `at`: 0 for the position, 3 for the rotation.
const block = (c: readonly number[], at: 0 | 3): Symmetric3 => {
  const entry = (row: number, column: number) =>
    c[(at + row) * 6 + at + column]!;
  return [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2),
    entry(2, 2)];
};

export interface Accuracy {
  readonly positionM: number;
  readonly rotationDeg: number;
}

/**
 * Longest half axes of the 95 % ellipsoids of a row-major 6x6 covariance, as
 * the server's GeoPose answers have them: sqrt(7.815 * largest eigenvalue).
 */
export const accuracyOf = (covariance: readonly number[]): Accuracy => ({
  positionM: Math.sqrt(CHI_SQUARE_95 * largestEigenvalue(block(covariance, 0))),
  rotationDeg: Math.sqrt(
      CHI_SQUARE_95 * largestEigenvalue(block(covariance, 3))) * 180 / Math.PI,
});
