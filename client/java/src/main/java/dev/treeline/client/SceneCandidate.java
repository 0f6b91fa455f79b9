package dev.treeline.client;

/** A scene that the server considered, if it was to choose one. */
public final class SceneCandidate {
  /** Its name. */
  public final String scene;
  /** In [0, 1], comparable within one answer only. */
  public final double similarity;
  /** Whether a pose in it was looked for; the rest is of that. */
  public final boolean tried;
  /** Whether one was found. */
  public final boolean localized;
  /** In [0, 1]. */
  public final double confidence;
  /** Samples that the pose explains. */
  public final int inliers;

  SceneCandidate(String scene, double similarity, boolean tried,
      boolean localized, double confidence, int inliers) {
    this.scene = scene;
    this.similarity = similarity;
    this.tried = tried;
    this.localized = localized;
    this.confidence = confidence;
    this.inliers = inliers;
  }
}
