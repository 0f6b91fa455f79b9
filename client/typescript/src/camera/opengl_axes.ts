// The axes of OpenGL, ARKit, ARCore and WebXR: x right, y up, z backwards.
// Treeline's: x right, y down, z forward. Half a turn about x lies between.

import { compose, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { ZERO } from '../geometry/vector3.js';

const OPENGL_FROM_CAMERA: RigidTransform =
    { rotation: { w: 0, x: 1, y: 0, z: 0 }, translationM: ZERO };

/** The pose of Treeline's camera frame from that of an OpenGL camera. */
export const fromOpenGlCamera = (
    targetFromOpenGlCamera: RigidTransform): RigidTransform =>
  compose(targetFromOpenGlCamera, OPENGL_FROM_CAMERA);

/** The pose of an OpenGL camera from that of Treeline's camera frame. */
export const toOpenGlCamera = (
    targetFromCamera: RigidTransform): RigidTransform =>
  // Half a turn is its own inverse.
  compose(targetFromCamera, OPENGL_FROM_CAMERA);
