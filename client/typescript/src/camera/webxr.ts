// WebXR: XRView with Raw Camera Access.

import { fromColumnMajor4, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { pinhole, type Camera } from './camera.js';
import { fromOpenGlCamera } from './opengl_axes.js';

/**
 * The camera of XRView.projectionMatrix, column-major, for the picture of
 * XRView.camera (XRCamera.width x height), which the matrix describes. With
 * normalised device coordinates (-1, 1) at the picture's top left corner, that
 * is at pixel (-0.5, -0.5):
 *   fx = P0 w / 2,  cx = w (1 - P8) / 2 - 0.5,
 *   fy = P5 h / 2,  cy = h (1 + P9) / 2 - 0.5.
 */
export function cameraFromWebXr(projectionMatrix: ArrayLike<number>,
    widthPx: number, heightPx: number): Camera {
  const p = projectionMatrix;
  if (p.length !== 16) {
    throw new RangeError(`a 4x4 matrix has 16 entries, not ${p.length}`);
  }
  if (p[11] !== -1 || p[15] !== 0) {
    throw new RangeError('the matrix is no perspective projection');
  }
  return pinhole({
    widthPx,
    heightPx,
    fxPx: p[0]! * widthPx / 2,
    fyPx: p[5]! * heightPx / 2,
    cxPx: widthPx * (1 - p[8]!) / 2 - 0.5,
    cyPx: heightPx * (1 + p[9]!) / 2 - 0.5,
  });
}

/**
 * deviceFromCamera of XRView.transform.matrix, column-major. `device` is the
 * XRReferenceSpace that the pose was asked in; its `reset` event is a
 * trackingReset() of the DriftCorrector.
 */
export const deviceFromCameraOfWebXr = (
    viewTransformMatrix: ArrayLike<number>): RigidTransform =>
  fromOpenGlCamera(fromColumnMajor4(viewTransformMatrix));
