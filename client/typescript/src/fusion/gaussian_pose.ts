// A pose worldFromCamera that is known up to a normal distribution: with
// (translation, rotation) zero-mean of `covariance`, the truth is
//   (Exp(rotation) * rotation of the pose, translation of the pose +
//   translation), both expressed in the world, as docs/frames.md has it.

import { addMatrices, cholesky, multiplyMatrices, solveCholesky, transpose,
  type Matrix } from '../geometry/matrix.js';
import type { RigidTransform } from '../geometry/rigid_transform.js';
import { conjugate, fromAxisAngle, multiply, normalized, toAxisAngle } from
  '../geometry/rotation.js';
import { add, subtract, type Vector3 } from '../geometry/vector3.js';

export interface GaussianPose {
  readonly worldFromCamera: RigidTransform;
  /** Row-major 6x6: x, y, z (m), rotation about x, y, z (rad). */
  readonly covariance: Matrix;
}

/** diag(v, v, v, r, r, r). */
export function diagonal(positionVarianceM2: number,
    rotationVarianceRad2: number): number[] {
  const matrix = new Array<number>(36).fill(0);
  for (let i = 0; i < 6; ++i) {
    matrix[7 * i] = i < 3 ? positionVarianceM2 : rotationVarianceRad2;
  }
  return matrix;
}

// What rounding does to a covariance, as a share of its largest variance and in
// m^2 or rad^2: a deviation of 0.03 mm.
const ROUNDING = 1e-9;

/** Whether it is 6x6, finite, and symmetric and positive semidefinite to
 * rounding. */
export function isCovariance(matrix: Matrix): boolean {
  if (matrix.length !== 36 || !matrix.every(Number.isFinite)) return false;
  const tolerance = ROUNDING * Math.max(
      1, ...matrix.filter((_, index) => index % 7 === 0));
  const mirrored = transpose(matrix, 6);
  return matrix.every((value, index) =>
    Math.abs(value - mirrored[index]!) <= tolerance) &&
    cholesky(addMatrices(matrix, diagonal(tolerance, tolerance)), 6) !== null;
}

/**
 * The covariance of the same camera after it moved by `movedInWorldM`: an error
 * of rotation at the start is an error of position at the end.
 *   F * covariance * F^T,  F = [I, -[moved]x; 0, I]
 */
export function transported(
    covariance: Matrix, { x, y, z }: Vector3): number[] {
  const f = diagonal(1, 1);
  f[4] = z;
  f[5] = -y;
  f[9] = -z;
  f[11] = x;
  f[15] = y;
  f[16] = -x;
  return multiplyMatrices(
      multiplyMatrices(f, covariance, 6), transpose(f, 6), 6);
}

/** How pose `b` differs from `a`: translation (m), then rotation (rad). */
export function difference(a: RigidTransform, b: RigidTransform): number[] {
  const t = subtract(b.translationM, a.translationM);
  const r = toAxisAngle(multiply(b.rotation, conjugate(a.rotation)));
  return [t.x, t.y, t.z, r.x, r.y, r.z];
}

export const lengthOfTranslationM = (delta: readonly number[]): number =>
  Math.hypot(delta[0]!, delta[1]!, delta[2]!);

export const angleOfRotationRad = (delta: readonly number[]): number =>
  Math.hypot(delta[3]!, delta[4]!, delta[5]!);

/** `pose` moved by what difference() gives. */
export const moved = (
    pose: RigidTransform, delta: readonly number[]): RigidTransform => ({
  rotation: normalized(multiply(
      fromAxisAngle({ x: delta[3]!, y: delta[4]!, z: delta[5]! }),
      pose.rotation)),
  translationM: add(
      pose.translationM, { x: delta[0]!, y: delta[1]!, z: delta[2]! }),
});

/** r^T (A + B)^-1 r of the difference r; infinite if A + B is not positive
 * definite. */
export function squaredDistance(a: GaussianPose, b: GaussianPose): number {
  const factor = cholesky(addMatrices(a.covariance, b.covariance), 6);
  if (factor === null) return Infinity;
  const r = difference(a.worldFromCamera, b.worldFromCamera);
  const weighted = solveCholesky(factor, r);
  return r.reduce((sum, value, i) => sum + value * weighted[i]!, 0);
}

/**
 * Both as one: each counts by its information.
 *   gain K = A (A + B)^-1, pose = a moved by K r, covariance = A - K A
 * A + B is positive definite.
 */
export function fused(a: GaussianPose, b: GaussianPose): GaussianPose {
  const factor = cholesky(addMatrices(a.covariance, b.covariance), 6)!;
  const r = difference(a.worldFromCamera, b.worldFromCamera);
  const weighted = solveCholesky(factor, r);
  const delta: number[] = [];
  // Row i: (A + B)^-1 times column i of A, which is symmetric.
  const rows: number[][] = [];
  for (let i = 0; i < 6; ++i) {
    const row = a.covariance.slice(6 * i, 6 * i + 6);
    delta.push(row.reduce((sum, value, k) => sum + value * weighted[k]!, 0));
    rows.push(solveCholesky(factor, row));
  }
  const reduced = a.covariance.map((value, index) => {
    const i = Math.floor(index / 6);
    const k = index % 6;
    let sum = 0;
    for (let m = 0; m < 6; ++m) sum += a.covariance[6 * i + m]! * rows[k]![m]!;
    return value - sum;
  });
  return {
    worldFromCamera: moved(a.worldFromCamera, delta),
    covariance: reduced.map(
        (value, index) => (value + reduced[(index % 6) * 6 +
          Math.floor(index / 6)]!) / 2),
  };
}

/** The largest standard deviation along an axis of the world (m). */
export const positionSigmaM = (covariance: Matrix): number =>
  Math.sqrt(Math.max(covariance[0]!, covariance[7]!, covariance[14]!));

/** The largest standard deviation about an axis of the world (rad). */
export const rotationSigmaRad = (covariance: Matrix): number =>
  Math.sqrt(Math.max(covariance[21]!, covariance[28]!, covariance[35]!));
