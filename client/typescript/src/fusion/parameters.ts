// Every number of the drift corrector. docs/explanation/device-fusion.md has
// this table with the reasons; C++, Java and this package have the same values.

export interface DriftParameters {
  /** Fixes of less confidence are ignored; in [0, 1]. */
  readonly minConfidence: number;
  /** Fixes with a larger standard deviation along an axis are ignored. */
  readonly maxFixSigmaM: number;
  readonly maxFixSigmaDeg: number;
  /** Added to the deviations that a fix states: what its covariance leaves out,
   * such as calibration and latency. */
  readonly fixSigmaFloorM: number;
  readonly fixSigmaFloorDeg: number;
  /** Variance of a fix whose view is that of the last one: they err alike. */
  readonly repeatedViewFactor: number;

  /** Drift of the tracking, as standard deviations that grow with the root of
   * the metres moved, radians turned and seconds passed. */
  readonly driftMPerSqrtM: number;
  readonly driftMPerSqrtS: number;
  readonly driftDegPerSqrtM: number;
  readonly driftDegPerSqrtRad: number;
  readonly driftDegPerSqrtS: number;

  /** A fix agrees with the world, or with other fixes, up to this squared
   * Mahalanobis distance (chi-square with 6 degrees of freedom). */
  readonly worldGate: number;
  readonly agreementGate: number;
  /** One fix alone corrects the world by no more than this; beyond, it must be
   * agreed with. */
  readonly maxSingleFixM: number;
  readonly maxSingleFixDeg: number;

  /** Product of the odds c / (1 - c) of fixes that agree, before they count;
   * and the most that one of them counts. */
  readonly minOdds: number;
  readonly maxOddsOfFix: number;
  /** The first lock, and jumps within the world's own uncertainty: this many
   * views that differ, or this many fixes without. */
  readonly lockViews: number;
  readonly lockFixes: number;
  readonly lockViewM: number;
  readonly lockViewDeg: number;
  /** Jumps that the world's uncertainty does not explain. */
  readonly contradictionViews: number;
  readonly contradictionViewM: number;
  readonly contradictionViewDeg: number;
  /** What nobody supports for so long is forgotten. */
  readonly hypothesisLifetimeS: number;
  readonly maxHypotheses: number;

  /** Lost: no good fix for so long, or uncertain beyond this. */
  readonly lostAfterS: number;
  readonly lostSigmaM: number;
  readonly lostSigmaDeg: number;

  /** How fast what is shown moves to what is known; beyond, it snaps. */
  readonly maxCorrectionMps: number;
  readonly maxCorrectionDegps: number;
  readonly snapM: number;
  readonly snapDeg: number;

  /** How far back fixes may have been captured. */
  readonly historyS: number;
  /** Tracking that leaves a longer gap, or is faster, has begun anew. */
  readonly maxGapS: number;
  readonly maxSpeedMps: number;
  readonly maxTurnDegps: number;
}

export const DEFAULT_PARAMETERS: DriftParameters = {
  minConfidence: 0.5,
  maxFixSigmaM: 0.3,
  maxFixSigmaDeg: 5,
  fixSigmaFloorM: 0.02,
  fixSigmaFloorDeg: 0.5,
  repeatedViewFactor: 4,
  driftMPerSqrtM: 0.03,
  driftMPerSqrtS: 0.002,
  driftDegPerSqrtM: 0.15,
  driftDegPerSqrtRad: 0.3,
  driftDegPerSqrtS: 0.02,
  worldGate: 22.46,
  agreementGate: 16.81,
  maxSingleFixM: 0.15,
  maxSingleFixDeg: 3,
  minOdds: 99,
  maxOddsOfFix: 49,
  lockViews: 2,
  lockFixes: 4,
  lockViewM: 0.05,
  lockViewDeg: 2,
  contradictionViews: 3,
  contradictionViewM: 0.3,
  contradictionViewDeg: 15,
  hypothesisLifetimeS: 30,
  maxHypotheses: 8,
  lostAfterS: 60,
  lostSigmaM: 0.5,
  lostSigmaDeg: 5,
  maxCorrectionMps: 0.05,
  maxCorrectionDegps: 2,
  snapM: 1,
  snapDeg: 20,
  historyS: 10,
  maxGapS: 1,
  maxSpeedMps: 10,
  maxTurnDegps: 720,
};

/** Throws a RangeError that names the first parameter that makes no sense. */
export function validateParameters(parameters: DriftParameters): void {
  for (const [name, value] of Object.entries(parameters)) {
    if (!(Number.isFinite(value) && value > 0)) {
      throw new RangeError(`${name}: ${value} is not positive`);
    }
  }
  if (parameters.minConfidence > 1) {
    throw new RangeError('minConfidence: is more than 1');
  }
}

export const radians = (deg: number): number => deg * Math.PI / 180;
export const degrees = (rad: number): number => rad * 180 / Math.PI;
