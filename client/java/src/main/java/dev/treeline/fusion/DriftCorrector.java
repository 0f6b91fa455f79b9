package dev.treeline.fusion;

import dev.treeline.fusion.Hypothesis.CarriedFix;
import dev.treeline.geometry.Quaternion;
import dev.treeline.geometry.RigidTransform;
import dev.treeline.geometry.Vector3;
import java.util.ArrayList;
import java.util.HashSet;
import java.util.List;
import java.util.Set;

/**
 * Fixes of a server and the device's own tracking become one world.
 *
 * <p>The device tracks itself smoothly, but in a frame of its own that drifts.
 * A server says where single pictures were taken, late and sometimes wrongly.
 * This keeps worldFromDevice between them:
 * {@code worldFromCamera = worldFromDevice.times(deviceFromCamera)}.
 * docs/explanation/device-fusion.md has the algorithm, step by step; C++ and
 * TypeScript have others of it, and all reproduce client/fusion_vectors.
 *
 * <p>It has no clock and draws no random numbers: the same calls give the same
 * results. Times are nanoseconds on any clock that never goes back, as
 * {@code Frame.getTimestamp()} of ARCore. Its methods may be called from any
 * thread: tracking from that which draws, fixes from that which has the answer.
 */
public final class DriftCorrector {
  private static final double UNIT_TOLERANCE = 0.01;

  private final DriftParameters parameters;
  private final TrackHistory history;
  private final ShownWorld shown;
  private Hypothesis world;
  private boolean isLost;
  private List<Hypothesis> others = new ArrayList<>();
  private Long goodFixNs;
  // Capture times, within the history, of the fixes that have counted.
  private final Set<Long> countedNs = new HashSet<>();

  /** With the parameters that all clients have. */
  public DriftCorrector() {
    this(new DriftParameters());
  }

  /**
   * With other parameters.
   *
   * @param parameters which are copied
   * @throws IllegalArgumentException for those that make no sense
   */
  public DriftCorrector(DriftParameters parameters) {
    this.parameters = parameters.copy();
    this.parameters.validate();
    history = new TrackHistory(this.parameters);
    shown = new ShownWorld(this.parameters);
  }

  /**
   * What is known.
   *
   * @return after the last call
   */
  public synchronized DriftState state() {
    if (world != null) return isLost ? DriftState.LOST : DriftState.LOCKED;
    return others.isEmpty() ? DriftState.SEARCHING : DriftState.TENTATIVE;
  }

  /**
   * The device's tracking, each frame, in the order of time.
   *
   * @param timeNs later than that of the last call
   * @param deviceFromCamera see {@code ArCore}
   * @return what is known now
   * @throws IllegalArgumentException and changes nothing, for a time that is
   *     not later and for what is no pose
   */
  public synchronized DriftEstimate track(
      long timeNs, RigidTransform deviceFromCamera) {
    validatePose(deviceFromCamera);
    TrackedPose last = history.newest();
    if (last != null && timeNs <= last.timeNs) {
      throw new IllegalArgumentException(
          timeNs + " ns is not later than " + last.timeNs + " ns");
    }
    boolean trackingBroke = history.isBroken(timeNs, deviceFromCamera);
    if (trackingBroke) trackingReset();
    TrackedPose now = history.add(timeNs, deviceFromCamera);
    if (last != null && !trackingBroke) {
      double[] drift = history.drift(last, now);
      if (world != null) world.follow(last, now, drift);
      for (Hypothesis other : others) other.follow(last, now, drift);
    }
    forget(timeNs);
    noticeLoss(timeNs);
    double passedS =
        last == null ? 0 : TrackHistory.seconds(last.timeNs, timeNs);
    boolean snapped = world != null && shown.step(
        world.pose().worldFromCamera, deviceFromCamera, passedS);
    return estimate(timeNs, deviceFromCamera, snapped, trackingBroke);
  }

  /**
   * A fix, as soon as the server has answered: late and out of order is fine
   * within historyS. Of several fixes of one capture time the first counts.
   *
   * @param fix of {@code LocalizeAnswer.fix}
   * @return what became of it
   * @throws IllegalArgumentException and changes nothing, for one that is no
   *     fix
   */
  public synchronized FixVerdict addFix(Fix fix) {
    validate(fix);
    DriftParameters p = parameters;
    if (fix.confidence < p.minConfidence) return FixVerdict.IGNORED_CONFIDENCE;
    if (GaussianPose.positionSigmaM(fix.covariance) > p.maxFixSigmaM
        || GaussianPose.rotationSigmaRad(fix.covariance)
            > Math.toRadians(p.maxFixSigmaDeg)) {
      return FixVerdict.IGNORED_UNCERTAIN;
    }
    CarriedFix carried = carry(fix);
    if (carried == null) return FixVerdict.IGNORED_UNTRACKED;
    if (!countedNs.add(fix.captureTimeNs)) return FixVerdict.IGNORED_REPEATED;
    if (world != null && corrects(carried)) {
      world.support(carried);
      good(carried);
      return FixVerdict.APPLIED;
    }
    Hypothesis hypothesis = hypothesisOf(carried);
    if (!wins(hypothesis)) return FixVerdict.HELD;
    FixVerdict verdict = world == null ? FixVerdict.LOCKED : FixVerdict.JUMPED;
    // What was lost is not moved: it begins anew.
    if (isLost) shown.clear();
    world = hypothesis;
    good(carried);
    return verdict;
  }

  /** Tracking began anew: poses from now on are in another device frame. */
  public synchronized void trackingReset() {
    history.clear();
    shown.clear();
    world = null;
    isLost = false;
    others = new ArrayList<>();
    countedNs.clear();
  }

  // The fix where the camera is now; null: nothing was tracked then.
  private CarriedFix carry(Fix fix) {
    TrackedPose captured = history.at(fix.captureTimeNs);
    TrackedPose newest = history.newest();
    if (captured == null || newest == null) return null;
    DriftParameters p = parameters;
    double[] covariance = Matrix.scaled(
        Matrix.sum(fix.covariance, GaussianPose.diagonal(
            TrackHistory.square(p.fixSigmaFloorM),
            TrackHistory.square(Math.toRadians(p.fixSigmaFloorDeg)))),
        1 / fix.confidence);
    RigidTransform worldFromCamera = fix.worldFromCamera
        .times(captured.deviceFromCamera.inverse())
        .times(newest.deviceFromCamera);
    Vector3 movedM = worldFromCamera.translationM.minus(
        fix.worldFromCamera.translationM);
    return new CarriedFix(new GaussianPose(worldFromCamera,
        Matrix.sum(GaussianPose.transported(covariance, movedM),
            history.drift(captured, newest))), fix.confidence, captured);
  }

  // Whether a fix is close enough to the world to be believed alone.
  private boolean corrects(CarriedFix fix) {
    double[] delta = GaussianPose.difference(
        world.pose().worldFromCamera, fix.now.worldFromCamera);
    DriftParameters p = parameters;
    return GaussianPose.lengthOfTranslationM(delta) <= p.maxSingleFixM
        && GaussianPose.angleOfRotationRad(delta)
            <= Math.toRadians(p.maxSingleFixDeg)
        && world.pose().squaredDistance(fix.now) <= p.worldGate;
  }

  // The hypothesis that the fix agrees with best, or a new one.
  private Hypothesis hypothesisOf(CarriedFix fix) {
    Hypothesis best = null;
    double least = parameters.agreementGate;
    for (Hypothesis other : others) {
      double distance = other.pose().squaredDistance(fix.now);
      if (distance <= least) {
        best = other;
        least = distance;
      }
    }
    if (best != null) {
      best.support(fix);
      return best;
    }
    if (others.size() >= parameters.maxHypotheses) {
      Hypothesis oldest = others.get(0);
      for (Hypothesis other : others) {
        if (other.lastSupportNs() < oldest.lastSupportNs()) oldest = other;
      }
      others.remove(oldest);
    }
    Hypothesis created = new Hypothesis(fix, parameters);
    others.add(created);
    return created;
  }

  // Whether a hypothesis is to be the world: it has enough support, more than
  // any other.
  private boolean wins(Hypothesis hypothesis) {
    for (Hypothesis other : others) {
      if (other != hypothesis && other.fixCount() >= hypothesis.fixCount()) {
        return false;
      }
    }
    boolean isExplained = world == null || isLost
        || world.pose().squaredDistance(hypothesis.pose())
            <= parameters.worldGate;
    return isExplained ? hypothesis.mayLock() : hypothesis.mayContradict();
  }

  // The world has a fix: what contradicted it must begin again.
  private void good(CarriedFix fix) {
    long timeNs = fix.captured.timeNs;
    goodFixNs = goodFixNs == null ? timeNs : Math.max(goodFixNs, timeNs);
    others = new ArrayList<>();
    isLost = false;
  }

  // What is too old to count.
  private void forget(long nowNs) {
    others.removeIf(other ->
        TrackHistory.seconds(other.lastSupportNs(), nowNs)
            > parameters.hypothesisLifetimeS);
    long oldestNs = history.oldest().timeNs;
    countedNs.removeIf(captureNs -> captureNs < oldestNs);
  }

  private void noticeLoss(long nowNs) {
    if (world == null || goodFixNs == null) return;
    DriftParameters p = parameters;
    double[] covariance = world.pose().covariance;
    if (TrackHistory.seconds(goodFixNs, nowNs) > p.lostAfterS
        || GaussianPose.positionSigmaM(covariance) > p.lostSigmaM
        || GaussianPose.rotationSigmaRad(covariance)
            > Math.toRadians(p.lostSigmaDeg)) {
      isLost = true;
    }
  }

  private DriftEstimate estimate(long timeNs, RigidTransform deviceFromCamera,
      boolean snapped, boolean trackingBroke) {
    RigidTransform worldFromDevice = shown.current();
    double[] covariance = world == null ? null : world.pose().covariance;
    int contradictingViews = 0;
    if (world != null) {
      for (Hypothesis other : others) {
        contradictingViews =
            Math.max(contradictingViews, other.contradictionViewCount());
      }
    }
    return new DriftEstimate(state(), worldFromDevice,
        worldFromDevice == null ? null
            : worldFromDevice.times(deviceFromCamera),
        covariance == null ? Double.NaN
            : GaussianPose.positionSigmaM(covariance),
        covariance == null ? Double.NaN
            : Math.toDegrees(GaussianPose.rotationSigmaRad(covariance)),
        goodFixNs == null ? Double.NaN
            : TrackHistory.seconds(goodFixNs, timeNs),
        contradictingViews, snapped, trackingBroke);
  }

  private static void validatePose(RigidTransform pose) {
    Quaternion q = pose.rotation;
    double size = q.norm() + pose.translationM.norm();
    if (Double.isNaN(size) || Double.isInfinite(size)) {
      throw new IllegalArgumentException("a pose has a NaN or an infinity");
    }
    if (Math.abs(q.norm() - 1) > UNIT_TOLERANCE) {
      throw new IllegalArgumentException("the rotation of a pose has norm 1");
    }
  }

  private static void validate(Fix fix) {
    validatePose(fix.worldFromCamera);
    if (!(fix.confidence >= 0 && fix.confidence <= 1)) {
      throw new IllegalArgumentException(
          "the confidence of a fix is in [0, 1]");
    }
    if (!GaussianPose.isCovariance(fix.covariance)) {
      throw new IllegalArgumentException("the covariance of a fix is 6x6, "
          + "finite, symmetric and positive semidefinite");
    }
  }
}
