// ARCore: Camera of a Frame.
//
// Take getImageIntrinsics() with the CPU image, not getTextureIntrinsics(),
// and Camera.getPose(), not getDisplayOrientedPose(): image, intrinsics and
// pose then belong to the sensor's pixels, whichever way the phone is held.

import { normalized } from '../geometry/rotation.js';
import type { RigidTransform } from '../geometry/rigid_transform.js';
import { pinhole, type Camera } from './camera.js';
import { fromOpenGlCamera } from './opengl_axes.js';

/**
 * CameraIntrinsics: getFocalLength(), getPrincipalPoint() and
 * getImageDimensions(). ARCore does not say from where it counts the principal
 * point. It is taken to be the picture's top left corner, as in ARKit and in
 * OpenGL: half a pixel is subtracted.
 */
export const cameraFromArCore = (
    focalLengthPx: readonly [number, number],
    principalPointPx: readonly [number, number],
    imageDimensionsPx: readonly [number, number]): Camera => pinhole({
  widthPx: imageDimensionsPx[0],
  heightPx: imageDimensionsPx[1],
  fxPx: focalLengthPx[0],
  fyPx: focalLengthPx[1],
  cxPx: principalPointPx[0] - 0.5,
  cyPx: principalPointPx[1] - 0.5,
});

/**
 * deviceFromCamera of Camera.getPose(): its translation (tx, ty, tz) and its
 * rotation in ARCore's order (qx, qy, qz, qw). `device` is ARCore's world: y
 * up. ARCore may move its world between frames; report a jump to the
 * DriftCorrector with trackingReset().
 */
export function deviceFromCameraOfArCore(
    translationM: readonly [number, number, number],
    rotationXyzw: readonly [number, number, number, number]): RigidTransform {
  const [x, y, z, w] = rotationXyzw;
  return fromOpenGlCamera({
    rotation: normalized({ w, x, y, z }),
    translationM:
        { x: translationM[0], y: translationM[1], z: translationM[2] },
  });
}
