// Cameras as Treeline takes them.
//
// Frame: x right, y down, z forward along the optical axis, of the picture as
// it is sent. Pixels: x right, y down, and the centre of the top left pixel is
// (0, 0), so that a picture of width w covers x from -0.5 to w - 0.5.
// A pinhole camera images pointInCamera at
//   xPx = fxPx * x / z + cxPx,  yPx = fyPx * y / z + cyPx.

import { conjugate, rotate } from '../geometry/rotation.js';
import type { RigidTransform } from '../geometry/rigid_transform.js';
import { scale, type Vector3 } from '../geometry/vector3.js';

/** Names of COLMAP; the order of the parameters is COLMAP's too. */
export type CameraModel = 'SIMPLE_PINHOLE' | 'PINHOLE' | 'SIMPLE_RADIAL' |
  'RADIAL' | 'OPENCV' | 'FULL_OPENCV' | 'OPENCV_FISHEYE' | 'FOV' |
  'SIMPLE_RADIAL_FISHEYE' | 'RADIAL_FISHEYE' | 'THIN_PRISM_FISHEYE';

/**
 * Intrinsics of one camera. Principal points count from the centre of the top
 * left pixel, half a pixel less than what COLMAP writes: see fromColmap().
 */
export interface Camera {
  readonly model: CameraModel;
  /** Size of the picture that the parameters belong to. */
  readonly widthPx: number;
  readonly heightPx: number;
  readonly parameters: readonly number[];
}

/** Where a picture ends, and what its camera is without distortion. */
export interface Pinhole {
  readonly widthPx: number;
  readonly heightPx: number;
  readonly fxPx: number;
  readonly fyPx: number;
  /** From the centre of the top left pixel. */
  readonly cxPx: number;
  readonly cyPx: number;
}

export const pinhole = (p: Pinhole): Camera => ({
  model: 'PINHOLE',
  widthPx: p.widthPx,
  heightPx: p.heightPx,
  parameters: [p.fxPx, p.fyPx, p.cxPx, p.cyPx],
});

// How many of a model's first parameters are focal lengths; the centre follows.
const focalLengths = ({ model }: Camera): 1 | 2 =>
  ['SIMPLE_PINHOLE', 'SIMPLE_RADIAL', 'RADIAL', 'SIMPLE_RADIAL_FISHEYE',
    'RADIAL_FISHEYE'].includes(model) ? 1 : 2;

/** The camera without its distortion. */
export function pinholeOf(camera: Camera): Pinhole {
  const first = focalLengths(camera);
  const [fxPx, fyPx] = [camera.parameters[0]!, camera.parameters[first - 1]!];
  const [cxPx, cyPx] =
    [camera.parameters[first]!, camera.parameters[first + 1]!];
  return { widthPx: camera.widthPx, heightPx: camera.heightPx,
    fxPx, fyPx, cxPx, cyPx };
}

/** The same camera with its principal point moved by (dxPx, dyPx). */
export function withCentreMoved(
    camera: Camera, dxPx: number, dyPx: number): Camera {
  const first = focalLengths(camera);
  const parameters = camera.parameters.map((value, i) =>
    value + (i === first ? dxPx : i === first + 1 ? dyPx : 0));
  return { ...camera, parameters };
}

/**
 * The camera of a picture that was resized as a whole to widthPx x heightPx.
 * Edges stay edges: xPx' + 0.5 = (xPx + 0.5) * widthPx' / widthPx. Throws if a
 * model with one focal length is stretched.
 */
export function resized(
    camera: Camera, widthPx: number, heightPx: number): Camera {
  const sx = widthPx / camera.widthPx;
  const sy = heightPx / camera.heightPx;
  const first = focalLengths(camera);
  // Sizes are whole: a ratio that is kept as well as it can be is kept.
  const isStretched = Math.abs(sx - sy) * Math.max(camera.widthPx,
      camera.heightPx) > 1;
  if (first === 1 && isStretched) {
    throw new RangeError(
        `${camera.model} has one focal length and cannot be stretched`);
  }
  const parameters = camera.parameters.map((value, i) => {
    if (i === first) return (value + 0.5) * sx - 0.5;
    if (i === first + 1) return (value + 0.5) * sy - 0.5;
    return i === 0 ? value * sx : i < first ? value * sy : value;
  });
  return { ...camera, widthPx, heightPx, parameters };
}

/**
 * The camera of the part of a picture whose top left pixel was (leftPx, topPx).
 */
export const cropped = (camera: Camera, leftPx: number, topPx: number,
    widthPx: number, heightPx: number): Camera => ({
  ...withCentreMoved(camera, -leftPx, -topPx), widthPx, heightPx,
});

const GRAVITY_MPS2 = 9.81;

/**
 * The direction in which things fall in the camera's frame, for the query. Up
 * in the device's frame is y in ARKit, ARCore and WebXR.
 */
export const gravityInCamera = (
    deviceFromCamera: RigidTransform,
    upInDevice: Vector3 = { x: 0, y: 1, z: 0 }): Vector3 =>
  scale(rotate(conjugate(deviceFromCamera.rotation), upInDevice),
      -GRAVITY_MPS2);
