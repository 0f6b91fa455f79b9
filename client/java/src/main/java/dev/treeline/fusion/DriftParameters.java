package dev.treeline.fusion;

/**
 * Every number of the drift corrector. docs/explanation/device-fusion.md has
 * the reasons; C++ and TypeScript have the same values. Set what you want to be
 * different: {@code new DriftCorrector(parameters)} takes a copy.
 */
public final class DriftParameters {
  /** Fixes of less confidence are ignored; in [0, 1]. */
  public double minConfidence = 0.5;
  /** Fixes with a larger standard deviation along an axis are ignored. */
  public double maxFixSigmaM = 0.3;
  /** The same about an axis. */
  public double maxFixSigmaDeg = 5;
  /** Added to the deviations that a fix states, for what its covariance leaves
   * out. */
  public double fixSigmaFloorM = 0.02;
  /** The same of the rotation. */
  public double fixSigmaFloorDeg = 0.5;
  /** Variance of a fix whose view is that of the last one: they err alike. */
  public double repeatedViewFactor = 4;
  /** Drift of the tracking's position with the root of the metres moved. */
  public double driftMPerSqrtM = 0.03;
  /** Drift of the position with the root of the seconds passed. */
  public double driftMPerSqrtS = 0.002;
  /** Drift of the rotation with the root of the metres moved. */
  public double driftDegPerSqrtM = 0.15;
  /** Drift of the rotation with the root of the radians turned. */
  public double driftDegPerSqrtRad = 0.3;
  /** Drift of the rotation with the root of the seconds passed. */
  public double driftDegPerSqrtS = 0.02;
  /** A fix agrees with the world up to this squared Mahalanobis distance. */
  public double worldGate = 22.46;
  /** A fix agrees with other fixes up to this squared Mahalanobis distance. */
  public double agreementGate = 16.81;
  /** One fix alone corrects the world by no more than this. */
  public double maxSingleFixM = 0.15;
  /** The same of the rotation; beyond, it must be agreed with. */
  public double maxSingleFixDeg = 3;
  /** Product of the odds c / (1 - c) of fixes that agree, before they count. */
  public double minOdds = 99;
  /** The most that one of them counts. */
  public double maxOddsOfFix = 49;
  /** The first lock: so many views that differ, ... */
  public double lockViews = 2;
  /** ... or so many fixes without. */
  public double lockFixes = 4;
  /** Views differ that are so far apart, ... */
  public double lockViewM = 0.05;
  /** ... or turned by so much. */
  public double lockViewDeg = 2;
  /** Jumps that the world's uncertainty does not explain: so many views. */
  public double contradictionViews = 3;
  /** They differ if they are so far apart, ... */
  public double contradictionViewM = 0.3;
  /** ... or turned by so much. */
  public double contradictionViewDeg = 15;
  /** What nobody supports for so long is forgotten. */
  public double hypothesisLifetimeS = 30;
  /** So many are kept. */
  public double maxHypotheses = 8;
  /** Lost: no good fix for so long, ... */
  public double lostAfterS = 60;
  /** ... or more uncertain than this, ... */
  public double lostSigmaM = 0.5;
  /** ... or this. */
  public double lostSigmaDeg = 5;
  /** How fast what is shown moves to what is known. */
  public double maxCorrectionMps = 0.05;
  /** How fast it turns. */
  public double maxCorrectionDegps = 2;
  /** Beyond, it is set at once. */
  public double snapM = 1;
  /** The same of the rotation. */
  public double snapDeg = 20;
  /** How far back fixes may have been captured. */
  public double historyS = 10;
  /** Tracking that leaves a longer gap has begun anew, ... */
  public double maxGapS = 1;
  /** ... or is faster than this, ... */
  public double maxSpeedMps = 10;
  /** ... or turns faster than this. */
  public double maxTurnDegps = 720;

  /** The values that all clients have. */
  public DriftParameters() {}

  /** The same numbers, which nobody changes. */
  DriftParameters copy() {
    DriftParameters copy = new DriftParameters();
    copy.minConfidence = minConfidence;
    copy.maxFixSigmaM = maxFixSigmaM;
    copy.maxFixSigmaDeg = maxFixSigmaDeg;
    copy.fixSigmaFloorM = fixSigmaFloorM;
    copy.fixSigmaFloorDeg = fixSigmaFloorDeg;
    copy.repeatedViewFactor = repeatedViewFactor;
    copy.driftMPerSqrtM = driftMPerSqrtM;
    copy.driftMPerSqrtS = driftMPerSqrtS;
    copy.driftDegPerSqrtM = driftDegPerSqrtM;
    copy.driftDegPerSqrtRad = driftDegPerSqrtRad;
    copy.driftDegPerSqrtS = driftDegPerSqrtS;
    copy.worldGate = worldGate;
    copy.agreementGate = agreementGate;
    copy.maxSingleFixM = maxSingleFixM;
    copy.maxSingleFixDeg = maxSingleFixDeg;
    copy.minOdds = minOdds;
    copy.maxOddsOfFix = maxOddsOfFix;
    copy.lockViews = lockViews;
    copy.lockFixes = lockFixes;
    copy.lockViewM = lockViewM;
    copy.lockViewDeg = lockViewDeg;
    copy.contradictionViews = contradictionViews;
    copy.contradictionViewM = contradictionViewM;
    copy.contradictionViewDeg = contradictionViewDeg;
    copy.hypothesisLifetimeS = hypothesisLifetimeS;
    copy.maxHypotheses = maxHypotheses;
    copy.lostAfterS = lostAfterS;
    copy.lostSigmaM = lostSigmaM;
    copy.lostSigmaDeg = lostSigmaDeg;
    copy.maxCorrectionMps = maxCorrectionMps;
    copy.maxCorrectionDegps = maxCorrectionDegps;
    copy.snapM = snapM;
    copy.snapDeg = snapDeg;
    copy.historyS = historyS;
    copy.maxGapS = maxGapS;
    copy.maxSpeedMps = maxSpeedMps;
    copy.maxTurnDegps = maxTurnDegps;
    return copy;
  }

  /** Throws an IllegalArgumentException that names the first number that makes
   * no sense. */
  void validate() {
    requirePositive("minConfidence", minConfidence);
    requirePositive("maxFixSigmaM", maxFixSigmaM);
    requirePositive("maxFixSigmaDeg", maxFixSigmaDeg);
    requirePositive("fixSigmaFloorM", fixSigmaFloorM);
    requirePositive("fixSigmaFloorDeg", fixSigmaFloorDeg);
    requirePositive("repeatedViewFactor", repeatedViewFactor);
    requirePositive("driftMPerSqrtM", driftMPerSqrtM);
    requirePositive("driftMPerSqrtS", driftMPerSqrtS);
    requirePositive("driftDegPerSqrtM", driftDegPerSqrtM);
    requirePositive("driftDegPerSqrtRad", driftDegPerSqrtRad);
    requirePositive("driftDegPerSqrtS", driftDegPerSqrtS);
    requirePositive("worldGate", worldGate);
    requirePositive("agreementGate", agreementGate);
    requirePositive("maxSingleFixM", maxSingleFixM);
    requirePositive("maxSingleFixDeg", maxSingleFixDeg);
    requirePositive("minOdds", minOdds);
    requirePositive("maxOddsOfFix", maxOddsOfFix);
    requirePositive("lockViews", lockViews);
    requirePositive("lockFixes", lockFixes);
    requirePositive("lockViewM", lockViewM);
    requirePositive("lockViewDeg", lockViewDeg);
    requirePositive("contradictionViews", contradictionViews);
    requirePositive("contradictionViewM", contradictionViewM);
    requirePositive("contradictionViewDeg", contradictionViewDeg);
    requirePositive("hypothesisLifetimeS", hypothesisLifetimeS);
    requirePositive("maxHypotheses", maxHypotheses);
    requirePositive("lostAfterS", lostAfterS);
    requirePositive("lostSigmaM", lostSigmaM);
    requirePositive("lostSigmaDeg", lostSigmaDeg);
    requirePositive("maxCorrectionMps", maxCorrectionMps);
    requirePositive("maxCorrectionDegps", maxCorrectionDegps);
    requirePositive("snapM", snapM);
    requirePositive("snapDeg", snapDeg);
    requirePositive("historyS", historyS);
    requirePositive("maxGapS", maxGapS);
    requirePositive("maxSpeedMps", maxSpeedMps);
    requirePositive("maxTurnDegps", maxTurnDegps);
    if (minConfidence > 1) {
      throw new IllegalArgumentException("minConfidence: is more than 1");
    }
  }

  private static void requirePositive(String name, double value) {
    if (!(value > 0) || Double.isInfinite(value)) {
      throw new IllegalArgumentException(
          name + ": " + value + " is not positive");
    }
  }
}
