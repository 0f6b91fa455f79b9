// ARKit: ARFrame.camera of an ARSession.
//
// ARKit's captured image always lies as the sensor gives it: landscape right.
// ARCamera.transform belongs to that image: x right in it, y up, z backwards.
// So send the captured image as it is, whichever way the phone is held.

import { fromColumnMajor4, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { pinhole, type Camera } from './camera.js';
import { fromOpenGlCamera } from './opengl_axes.js';

/**
 * ARCamera.intrinsics, a column-major 3x3 matrix (nine numbers: fx, 0, 0, 0,
 * fy, 0, ox, oy, 1), with ARCamera.imageResolution. ARKit counts ox and oy from
 * the top left corner of the picture, Treeline from the centre of the first
 * pixel: half a pixel is subtracted.
 */
export function cameraFromArKit(intrinsics: ArrayLike<number>,
    widthPx: number, heightPx: number): Camera {
  if (intrinsics.length !== 9) {
    throw new RangeError(
        `a 3x3 matrix has 9 entries, not ${intrinsics.length}`);
  }
  return pinhole({ widthPx, heightPx, fxPx: intrinsics[0]!,
    fyPx: intrinsics[4]!, cxPx: intrinsics[6]! - 0.5,
    cyPx: intrinsics[7]! - 0.5 });
}

/**
 * deviceFromCamera of ARCamera.transform, a column-major 4x4 matrix. `device`
 * is ARKit's world: y up, its origin where the session began.
 */
export const deviceFromCameraOfArKit = (
    transform: ArrayLike<number>): RigidTransform =>
  fromOpenGlCamera(fromColumnMajor4(transform));
