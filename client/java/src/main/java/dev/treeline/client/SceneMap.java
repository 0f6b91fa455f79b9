package dev.treeline.client;

import dev.treeline.camera.Camera;
import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import java.util.List;


/** What a scene's model knows of it: for pictures. */
public final class SceneMap {
  /** Its name. */
  public final String scene;
  /** That was asked. */
  public final String modelVersion;
  /** x, y and z of each point. */
  public final float[] pointsInWorldM;
  /** Of each point, 0 to 255. */
  public final byte[] brightness;
  /** Of all, not only of those that were sent. */
  public final long pointsInModel;
  /** Where the keyframes were taken, in the order of the training frames. */
  public final List<RigidTransform> worldFromKeyframe;
  /** That took them. Null: it is not said. */
  public final Camera camera;
  /** Into a plan whose z is up. */
  public final Quaternion planFromWorld;
  /** Null: it was not asked for. */
  public final SceneCoverage coverage;

  SceneMap(String scene, String modelVersion, float[] pointsInWorldM,
      byte[] brightness, long pointsInModel,
      List<RigidTransform> worldFromKeyframe, Camera camera,
      Quaternion planFromWorld, SceneCoverage coverage) {
    this.scene = scene;
    this.modelVersion = modelVersion;
    this.pointsInWorldM = pointsInWorldM;
    this.brightness = brightness;
    this.pointsInModel = pointsInModel;
    this.worldFromKeyframe = worldFromKeyframe;
    this.camera = camera;
    this.planFromWorld = planFromWorld;
    this.coverage = coverage;
  }
}
