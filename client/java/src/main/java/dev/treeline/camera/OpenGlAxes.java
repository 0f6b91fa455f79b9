package dev.treeline.camera;

import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;

/**
 * The axes of cameras in OpenGL, ARCore, ARKit and WebXR: x right, y up, z
 * backwards. Treeline's: x right, y down, z forward. Half a turn about x lies
 * between.
 */
public final class OpenGlAxes {
  // Its own inverse.
  private static final RigidTransform OPENGL_FROM_CAMERA =
      new RigidTransform(new Quaternion(0, 1, 0, 0), Vector3.ZERO);

  private OpenGlAxes() {}

  /**
   * The pose of Treeline's camera frame.
   *
   * @param targetFromOpenGlCamera the pose of an OpenGL camera
   * @return targetFromCamera
   */
  public static RigidTransform fromOpenGlCamera(
      RigidTransform targetFromOpenGlCamera) {
    return targetFromOpenGlCamera.times(OPENGL_FROM_CAMERA);
  }

  /**
   * The pose of an OpenGL camera, to draw what it sees.
   *
   * @param targetFromCamera the pose of Treeline's camera frame
   * @return targetFromOpenGlCamera
   */
  public static RigidTransform toOpenGlCamera(
      RigidTransform targetFromCamera) {
    return targetFromCamera.times(OPENGL_FROM_CAMERA);
  }
}
