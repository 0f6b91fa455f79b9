// COLMAP. Models, names and the order of parameters are Treeline's. COLMAP puts
// the centre of the top left pixel at (0.5, 0.5), Treeline at (0, 0).

import { normalized } from '../geometry/rotation.js';
import { inverse, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { withCentreMoved, type Camera, type CameraModel } from './camera.js';

/** A line of cameras.txt: half a pixel is subtracted from cx and cy. */
export const cameraFromColmap = (
    model: CameraModel, widthPx: number, heightPx: number,
    parameters: readonly number[]): Camera =>
  withCentreMoved({ model, widthPx, heightPx, parameters }, -0.5, -0.5);

/** The parameters for cameras.txt, and for the GeoPose Protocol. */
export const colmapParameters = (camera: Camera): readonly number[] =>
  withCentreMoved(camera, 0.5, 0.5).parameters;

/**
 * worldFromCamera of a line of images.txt: QW QX QY QZ TX TY TZ, which map
 * points of the world into the camera.
 */
export function worldFromCameraOfColmap(
    qw: number, qx: number, qy: number, qz: number,
    tx: number, ty: number, tz: number): RigidTransform {
  return inverse({
    rotation: normalized({ w: qw, x: qx, y: qy, z: qz }),
    translationM: { x: tx, y: ty, z: tz },
  });
}
