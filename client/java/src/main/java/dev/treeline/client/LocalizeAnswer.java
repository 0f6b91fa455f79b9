package dev.treeline.client;

import dev.treeline.camera.Camera;
import dev.treeline.fusion.Fix;
import dev.treeline.geometry.RigidTransform;
import java.util.Collections;
import java.util.List;

/** "Not localized" is an answer like any other. */
public final class LocalizeAnswer {
  /** The camera of an RGB-D pair whose pose it is. */
  public enum PoseSensor {
    /** That which took the picture. */
    COLOR,
    /** That beside it. */
    DEPTH
  }

  /** Whether there is a pose. */
  public final boolean localized;
  /** Maps points of the camera's frame (x right, y down, z forward of the
   * picture as it was sent) into the scene's world. Null: not localized. */
  public final RigidTransform worldFromCamera;
  /** The camera that the training poses were of. */
  public final PoseSensor poseSensor;
  /** Empty: localized. TOO_FEW_SAMPLES, TOO_FEW_INLIERS, POORLY_CONSTRAINED,
   * LOW_CONFIDENCE, CONTRADICTS_PRIOR, CONTRADICTS_DEPTH or UNKNOWN_CAMERA. */
  public final String reason;
  /** Samples that the pose explains. */
  public final int inliers;
  /** Drawn from the picture. */
  public final int samples;
  /** In [0, 1]. */
  public final double inlierRatio;
  /** Probability that the pose is right, within 5 cm and 5 degrees. */
  public final double confidence;
  /** Of answers that reach it, 99 of 100 were right in training. */
  public final double confidenceThreshold;
  /** The pose is of a camera whose focal length is so many times the stated
   * one, since that fits better; 1: the stated one fits. */
  public final double focalScale;
  /** If localized by a picture of which no camera was stated, or a guess that
   * does not fit: the camera that the pose is of, found by what is seen. Null:
   * the stated one, or the scene's. */
  public final Camera camera;
  /** The pose is of depth that is so many times as large; 1: it fits. */
  public final double depthScale;
  /** Who answered. */
  public final String scene;
  /** Of that scene. */
  public final String modelVersion;
  /** The best first; empty if the query named its scene. */
  public final List<SceneCandidate> candidates;
  /** Empty unless they were asked for. */
  public final List<Correspondence> correspondences;
  /** Of the server. */
  public final ServerTimings timings;
  /** From the call to the answer, retries included. */
  public final long roundTripMs;
  private final double[] covariance;

  LocalizeAnswer(dev.treeline.proto.LocalizeResponse r,
      RigidTransform worldFromCamera, String reason, long roundTripMs) {
    localized = worldFromCamera != null;
    this.worldFromCamera = worldFromCamera;
    this.reason = reason;
    this.roundTripMs = roundTripMs;
    covariance = Convert.doubles(r.getCovarianceList());
    poseSensor =
        r.getPoseSensor() == dev.treeline.proto.RgbdSensor.RGBD_SENSOR_DEPTH
            ? PoseSensor.DEPTH : PoseSensor.COLOR;
    inliers = r.getInliers();
    samples = r.getSamples();
    inlierRatio = r.getInlierRatio();
    confidence = r.getConfidence();
    confidenceThreshold = r.getConfidenceThreshold();
    focalScale = r.hasFocalScale() ? r.getFocalScale() : 1;
    camera = r.hasCamera() ? Convert.camera(r.getCamera()) : null;
    depthScale = r.hasDepthScale() ? r.getDepthScale() : 1;
    scene = r.getScene();
    modelVersion = r.getModelVersion();
    candidates = Collections.unmodifiableList(
        Convert.each(r.getCandidatesList(), Convert::candidate));
    correspondences = Collections.unmodifiableList(
        Convert.each(r.getCorrespondencesList(), Convert::correspondence));
    timings = Convert.timings(r.getTimings());
  }

  /**
   * Row-major 6x6: x, y, z (m), rotation about x, y, z (rad), in the world.
   *
   * @return a copy; empty: not localized
   */
  public double[] covariance() {
    return covariance.clone();
  }

  /**
   * What {@code DriftCorrector} takes of it.
   *
   * @param captureTimeNs when the picture was taken, on the clock of the
   *     tracking
   * @return null: not localized
   */
  public Fix fix(long captureTimeNs) {
    return localized
        ? new Fix(captureTimeNs, worldFromCamera, covariance, confidence)
        : null;
  }
}
