// OpenCV. Its camera frame and its pixels are Treeline's: x right, y down, z
// forward, and the centre of the top left pixel is (0, 0).

import { fromAxisAngle } from '../geometry/rotation.js';
import { inverse, type RigidTransform } from
  '../geometry/rigid_transform.js';
import type { Vector3 } from '../geometry/vector3.js';
import { pinhole, type Camera } from './camera.js';

/**
 * The camera of calibrateCamera(): the row-major 3x3 matrix fx 0 cx 0 fy cy 0 0
 * 1, and no distortion coefficients, or 4, 5 or 8 of them (k1, k2, p1, p2, k3,
 * k4, k5, k6). Throws for other models of OpenCV.
 */
export function cameraFromOpenCv(
    cameraMatrix: ArrayLike<number>, widthPx: number, heightPx: number,
    distortion: ArrayLike<number> = []): Camera {
  if (cameraMatrix.length !== 9) {
    throw new RangeError(
        `a 3x3 matrix has 9 entries, not ${cameraMatrix.length}`);
  }
  const camera = pinhole({ widthPx, heightPx, fxPx: cameraMatrix[0]!,
    fyPx: cameraMatrix[4]!, cxPx: cameraMatrix[2]!, cyPx: cameraMatrix[5]! });
  const coefficients = Array.from(distortion);
  switch (coefficients.length) {
    case 0:
      return camera;
    case 4:
      return { ...camera, model: 'OPENCV',
        parameters: [...camera.parameters, ...coefficients] };
    case 5:
      return { ...camera, model: 'FULL_OPENCV',
        parameters: [...camera.parameters, ...coefficients, 0, 0, 0] };
    case 8:
      return { ...camera, model: 'FULL_OPENCV',
        parameters: [...camera.parameters, ...coefficients] };
    default:
      throw new RangeError(`there is no model with ${coefficients.length} ` +
          'distortion coefficients');
  }
}

/**
 * worldFromCamera of solvePnP's rvec (radians) and tvec, which map points of
 * the world into the camera.
 */
export const worldFromCameraOfOpenCv = (
    rvecRad: Vector3, tvecM: Vector3): RigidTransform =>
  inverse({ rotation: fromAxisAngle(rvecRad), translationM: tvecM });
