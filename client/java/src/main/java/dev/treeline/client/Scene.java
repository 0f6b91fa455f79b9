package dev.treeline.client;

import dev.treeline.camera.Camera;
import dev.treeline.geometry.Vector3;
import java.util.List;


/** A scene of the server. */
public final class Scene {
  /** As queries name it. */
  public final String name;
  /** Whether it answers. */
  public final SceneState state;
  /** Why it failed: "DATA_LOSS: ..."; empty otherwise. */
  public final String failure;
  /** The version that answers; empty if none does. */
  public final String modelVersion;
  /** All versions, the newest first. */
  public final List<String> versions;
  /** For people; empty if it has none. */
  public final String displayName;
  /** How the version that answers was learnt. Null: none answers. */
  public final String method;
  /** The camera of queries that bring none. Null: none answers. */
  public final Camera camera;
  /** Box of the training points. Null: none answers. */
  public final Vector3 boundsMinInWorldM;
  /** Its other corner. */
  public final Vector3 boundsMaxInWorldM;
  /** Where its world lies on the Earth. Null: nobody said. */
  public final GeoAnchor geoAnchor;

  Scene(String name, SceneState state, String failure, String modelVersion,
      List<String> versions, String displayName, String method, Camera camera,
      Vector3 boundsMinInWorldM, Vector3 boundsMaxInWorldM,
      GeoAnchor geoAnchor) {
    this.name = name;
    this.state = state;
    this.failure = failure;
    this.modelVersion = modelVersion;
    this.versions = versions;
    this.displayName = displayName;
    this.method = method;
    this.camera = camera;
    this.boundsMinInWorldM = boundsMinInWorldM;
    this.boundsMaxInWorldM = boundsMaxInWorldM;
    this.geoAnchor = geoAnchor;
  }
}
