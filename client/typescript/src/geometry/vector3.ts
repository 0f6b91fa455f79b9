// Vectors and points. A name says the frame and the unit: pointInWorldM.

export interface Vector3 {
  readonly x: number;
  readonly y: number;
  readonly z: number;
}

export const ZERO: Vector3 = { x: 0, y: 0, z: 0 };

export const add = (a: Vector3, b: Vector3): Vector3 =>
  ({ x: a.x + b.x, y: a.y + b.y, z: a.z + b.z });

export const subtract = (a: Vector3, b: Vector3): Vector3 =>
  ({ x: a.x - b.x, y: a.y - b.y, z: a.z - b.z });

export const scale = (a: Vector3, factor: number): Vector3 =>
  ({ x: a.x * factor, y: a.y * factor, z: a.z * factor });

export const cross = (a: Vector3, b: Vector3): Vector3 => ({
  x: a.y * b.z - a.z * b.y,
  y: a.z * b.x - a.x * b.z,
  z: a.x * b.y - a.y * b.x,
});

export const norm = (a: Vector3): number =>
  Math.sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
