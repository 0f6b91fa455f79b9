// Rigid transforms. One is named targetFromSource and maps points of the source
// frame into the target frame; in a product, neighbouring names match:
//   pointInWorld = transformPoint(worldFromCamera, pointInCamera)
//   worldFromCamera = compose(worldFromDevice, deviceFromCamera)

import {
  conjugate, fromRows, IDENTITY_ROTATION, multiply, normalized, rotate, slerp,
  type Quaternion,
} from './rotation.js';
import { add, scale, subtract, ZERO, type Vector3 } from './vector3.js';

/** pointInTarget = rotation * pointInSource + translationM. */
export interface RigidTransform {
  readonly rotation: Quaternion;
  readonly translationM: Vector3;
}

export const IDENTITY: RigidTransform =
    { rotation: IDENTITY_ROTATION, translationM: ZERO };

export const compose = (a: RigidTransform, b: RigidTransform):
    RigidTransform => ({
  rotation: normalized(multiply(a.rotation, b.rotation)),
  translationM: transformPoint(a, b.translationM),
});

export function inverse(a: RigidTransform): RigidTransform {
  const rotation = conjugate(a.rotation);
  return { rotation, translationM: scale(rotate(rotation, a.translationM), -1) };
}

export const transformPoint = (a: RigidTransform, point: Vector3): Vector3 =>
  add(rotate(a.rotation, point), a.translationM);

/** What lies at fraction t in [0, 1] from a to b: line and shorter arc. */
export const interpolate = (
    a: RigidTransform, b: RigidTransform, t: number): RigidTransform => ({
  rotation: slerp(a.rotation, b.rotation, t),
  translationM: add(a.translationM,
      scale(subtract(b.translationM, a.translationM), t)),
});

/**
 * The transform of a column-major 4x4 matrix: XRRigidTransform.matrix of
 * WebXR, simd_float4x4 of ARKit, Pose.toMatrix of ARCore.
 */
export function fromColumnMajor4(matrix: ArrayLike<number>): RigidTransform {
  if (matrix.length !== 16) {
    throw new RangeError(`a 4x4 matrix has 16 entries, not ${matrix.length}`);
  }
  const m = Array.from(matrix) as number[];
  return {
    rotation: fromRows([m[0]!, m[4]!, m[8]!, m[1]!, m[5]!, m[9]!, m[2]!, m[6]!,
      m[10]!]),
    translationM: { x: m[12]!, y: m[13]!, z: m[14]! },
  };
}

/** The column-major 4x4 matrix of a transform, as WebXR and WebGL take it. */
export function toColumnMajor4(a: RigidTransform): number[] {
  const x = rotate(a.rotation, { x: 1, y: 0, z: 0 });
  const y = rotate(a.rotation, { x: 0, y: 1, z: 0 });
  const z = rotate(a.rotation, { x: 0, y: 0, z: 1 });
  const t = a.translationM;
  return [x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0,
    t.x, t.y, t.z, 1];
}
