package dev.treeline.client;

/** Whether a scene answers. */
public enum SceneState {
  /** A newer server's word. */
  UNKNOWN,
  /** On disk, not in memory: the first query loads it. */
  UNLOADED,
  /** Soon. */
  LOADING,
  /** It does. */
  READY,
  /** It cannot: {@link Scene#failure} says why. */
  FAILED
}
