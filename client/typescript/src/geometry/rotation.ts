// Rotations as unit quaternions w + xi + yj + zk, Hamilton's convention.

import { cross, add, scale, norm, type Vector3 } from './vector3.js';

export interface Quaternion {
  readonly w: number;
  readonly x: number;
  readonly y: number;
  readonly z: number;
}

export const IDENTITY_ROTATION: Quaternion = { w: 1, x: 0, y: 0, z: 0 };

export const conjugate = ({ w, x, y, z }: Quaternion): Quaternion =>
  ({ w, x: -x, y: -y, z: -z });

/** The rotation `a * b`: first b, then a. */
export const multiply = (a: Quaternion, b: Quaternion): Quaternion => ({
  w: a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
  x: a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
  y: a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
  z: a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
});

/** The same rotation with norm 1 and w >= 0. */
export function normalized(q: Quaternion): Quaternion {
  const length = Math.sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  const factor = (q.w < 0 ? -1 : 1) / length;
  return { w: q.w * factor, x: q.x * factor, y: q.y * factor, z: q.z * factor };
}

export function rotate(q: Quaternion, v: Vector3): Vector3 {
  const twice = scale(cross(q, v), 2);
  return add(add(v, scale(twice, q.w)), cross(q, twice));
}

/** The rotation by |axisAngleRad| radians about axisAngleRad: Exp. */
export function fromAxisAngle(axisAngleRad: Vector3): Quaternion {
  const angleRad = norm(axisAngleRad);
  // sin(a/2)/a, by its series where the division loses digits.
  const factor = angleRad < 1e-6 ? 0.5 - angleRad * angleRad / 48 :
    Math.sin(angleRad / 2) / angleRad;
  const { x, y, z } = scale(axisAngleRad, factor);
  return normalized({ w: Math.cos(angleRad / 2), x, y, z });
}

/** The axis times the angle in [0, pi] radians: Log, the inverse of Exp. */
export function toAxisAngle(rotation: Quaternion): Vector3 {
  const q = normalized(rotation);
  const sine = norm(q);
  if (sine < 1e-9) return scale(q, 2);
  return scale(q, 2 * Math.atan2(sine, q.w) / sine);
}

/** The angle of the rotation that takes a to b, in [0, pi] radians. */
export const angleBetweenRad = (a: Quaternion, b: Quaternion): number =>
  norm(toAxisAngle(multiply(b, conjugate(a))));

/** What lies at fraction t in [0, 1] from a to b along the shorter arc. */
export const slerp = (a: Quaternion, b: Quaternion, t: number): Quaternion =>
  normalized(multiply(
      fromAxisAngle(scale(toAxisAngle(multiply(b, conjugate(a))), t)), a));

/**
 * The rotation of a row-major 3x3 matrix that is orthonormal to rounding, as
 * tracking software gives it.
 */
export function fromRows(rows: readonly number[]): Quaternion {
  const [xx, xy, xz, yx, yy, yz, zx, zy, zz] = rows as [number, number, number,
    number, number, number, number, number, number];
  // Four times the squares of w, x, y, z; the largest is divided by.
  const squares = [1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz,
    1 - xx - yy + zz];
  switch (squares.indexOf(Math.max(...squares))) {
    case 0: return normalized(
        { w: squares[0]!, x: zy - yz, y: xz - zx, z: yx - xy });
    case 1: return normalized(
        { w: zy - yz, x: squares[1]!, y: xy + yx, z: xz + zx });
    case 2: return normalized(
        { w: xz - zx, x: xy + yx, y: squares[2]!, z: yz + zy });
    default: return normalized(
        { w: yx - xy, x: xz + zx, y: yz + zy, z: squares[3]! });
  }
}
