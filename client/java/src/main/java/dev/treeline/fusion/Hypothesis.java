package dev.treeline.fusion;

import dev.treeline.geometry.RigidTransform;
import java.util.ArrayList;
import java.util.List;

/** Where the world may be, and which fixes say so. */
final class Hypothesis {
  /** A fix, carried along the tracking to the newest tracked pose. */
  static final class CarriedFix {
    final GaussianPose now;
    final double confidence;
    final TrackedPose captured;

    CarriedFix(GaussianPose now, double confidence, TrackedPose captured) {
      this.now = now;
      this.confidence = confidence;
      this.captured = captured;
    }
  }

  // deviceFromCamera of views, no two of which are alike. No more are kept than
  // are asked for, so that neither memory nor work grows with time.
  private static final class Views {
    private final List<RigidTransform> views = new ArrayList<>();
    private final double enough;
    private final double distanceM;
    private final double angleDeg;

    Views(double enough, double distanceM, double angleDeg) {
      this.enough = enough;
      this.distanceM = distanceM;
      this.angleDeg = angleDeg;
    }

    boolean areEnough() {
      return views.size() >= enough;
    }

    void add(RigidTransform view) {
      if (areEnough()) return;
      for (RigidTransform other : views) {
        if (!areDistinct(view, other, distanceM, angleDeg)) return;
      }
      views.add(view);
    }
  }

  private final DriftParameters parameters;
  private final Views lockViews;
  private final Views contradictionViews;
  private GaussianPose current;
  private RigidTransform lastView;
  private long supportedNs;
  private double logOdds = 0;
  private int fixes = 0;

  Hypothesis(CarriedFix first, DriftParameters parameters) {
    DriftParameters p = parameters;
    this.parameters = p;
    current = first.now;
    lastView = first.captured.deviceFromCamera;
    supportedNs = first.captured.timeNs;
    lockViews = new Views(p.lockViews, p.lockViewM, p.lockViewDeg);
    contradictionViews = new Views(
        p.contradictionViews, p.contradictionViewM, p.contradictionViewDeg);
    count(first);
  }

  /** worldFromCamera at the newest tracked pose. */
  GaussianPose pose() {
    return current;
  }

  /** Capture time of the newest fix that supports it. */
  long lastSupportNs() {
    return supportedNs;
  }

  int fixCount() {
    return fixes;
  }

  int contradictionViewCount() {
    return contradictionViews.views.size();
  }

  /** Along the tracking to its newest pose, whose drift since is `drift`. */
  void follow(TrackedPose from, TrackedPose to, double[] drift) {
    RigidTransform worldFromCamera = current.worldFromCamera
        .times(from.deviceFromCamera.inverse()).times(to.deviceFromCamera);
    double[] covariance = GaussianPose.transported(current.covariance,
        worldFromCamera.translationM.minus(
            current.worldFromCamera.translationM));
    current = new GaussianPose(
        worldFromCamera, Matrix.sum(covariance, drift));
  }

  /** Takes a fix that agrees into account. */
  void support(CarriedFix fix) {
    DriftParameters p = parameters;
    RigidTransform view = fix.captured.deviceFromCamera;
    double factor =
        areDistinct(view, lastView, p.lockViewM, p.lockViewDeg)
            ? 1 : p.repeatedViewFactor;
    current = current.fused(new GaussianPose(fix.now.worldFromCamera,
        Matrix.scaled(fix.now.covariance, factor)));
    lastView = view;
    supportedNs = Math.max(supportedNs, fix.captured.timeNs);
    count(fix);
  }

  /** Whether its fixes are enough for a world to begin with. */
  boolean mayLock() {
    return areOddsEnough()
        && (lockViews.areEnough() || fixes >= parameters.lockFixes);
  }

  /** Whether its fixes are enough against a world that contradicts them. */
  boolean mayContradict() {
    return areOddsEnough() && contradictionViews.areEnough();
  }

  private boolean areOddsEnough() {
    return logOdds >= Math.log(parameters.minOdds);
  }

  private void count(CarriedFix fix) {
    double most = parameters.maxOddsOfFix;
    double odds = fix.confidence * (1 + most) >= most
        ? most : fix.confidence / (1 - fix.confidence);
    logOdds += Math.log(odds);
    fixes += 1;
    lockViews.add(fix.captured.deviceFromCamera);
    contradictionViews.add(fix.captured.deviceFromCamera);
  }

  private static boolean areDistinct(RigidTransform a, RigidTransform b,
      double distanceM, double angleDeg) {
    return a.translationM.minus(b.translationM).norm() >= distanceM
        || a.rotation.angleToRad(b.rotation) >= Math.toRadians(angleDeg);
  }
}
