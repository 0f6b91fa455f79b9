// Fixes of a server and the device's own tracking become one world.
//
// The device tracks itself smoothly, but in a frame of its own that drifts. A
// server says where single pictures were taken, late and sometimes wrongly.
// DriftCorrector keeps worldFromDevice between them:
//   worldFromCamera = compose(worldFromDevice, deviceFromCamera).
// docs/explanation/device-fusion.md has the algorithm, step by step.

import { addMatrices } from '../geometry/matrix.js';
import { compose, inverse, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { subtract } from '../geometry/vector3.js';
import { angleOfRotationRad, diagonal, difference, isCovariance,
  lengthOfTranslationM, positionSigmaM, rotationSigmaRad, squaredDistance, transported } from
  './gaussian_pose.js';
import { Hypothesis, type CarriedFix } from './hypothesis.js';
import { DEFAULT_PARAMETERS, degrees, radians, validateParameters,
  type DriftParameters } from './parameters.js';
import { ShownWorld } from './shown_world.js';
import { TrackHistory } from './track_history.js';

/** What the server says of one picture. */
export interface Fix {
  /** When the picture was taken, on the clock of track(). */
  readonly captureTimeMs: number;
  readonly worldFromCamera: RigidTransform;
  /** Row-major 6x6, as LocalizeAnswer has it. */
  readonly covariance: readonly number[];
  /** In [0, 1]. */
  readonly confidence: number;
}

/**
 * `searching`: nothing is known. `tentative`: fixes wait for others that agree.
 * `locked`: worldFromDevice holds. `lost`: it is the last that was known, and
 * may be wrong.
 */
export type DriftState = 'searching' | 'tentative' | 'locked' | 'lost';

/**
 * What became of a fix. `applied`: it corrected the world. `locked`: with it
 * the world began. `jumped`: with it others won over the world that was.
 * `held`: it waits for others that agree. The rest were ignored: too little
 * confidence, too uncertain, captured when nothing was tracked, or of a picture
 * that has counted already.
 */
export type FixVerdict = 'applied' | 'locked' | 'jumped' | 'held' |
  'ignored_confidence' | 'ignored_uncertain' | 'ignored_untracked' |
  'ignored_repeated';

/** What is known at the time of a tracked pose. */
export interface DriftEstimate {
  readonly state: DriftState;
  /** For drawing: smooth. Null while searching or tentative. */
  readonly worldFromDevice: RigidTransform | null;
  /** The same for the tracked pose. */
  readonly worldFromCamera: RigidTransform | null;
  /** Of worldFromCamera as it is known, to which the drawn one moves: largest
   * standard deviations along and about an axis of the world. */
  readonly positionSigmaM: number | null;
  readonly rotationSigmaDeg: number | null;
  /** Since the last fix that the world was built on was captured; null: there
   * was none yet. */
  readonly sinceGoodFixS: number | null;
  /** Distinct views of the fixes that speak most against the world; counted up
   * to contradictionViews. */
  readonly contradictingViews: number;
  /** Whether worldFromDevice was set at once, not moved. */
  readonly snapped: boolean;
  /** Whether tracking began anew with this pose, by a gap or a jump. */
  readonly trackingBroke: boolean;
}

/**
 * Pure: it has no clock and draws no random numbers. The same calls give the
 * same results.
 */
export class DriftCorrector {
  private readonly parameters: DriftParameters;
  private readonly history: TrackHistory;
  private readonly shown: ShownWorld;
  private world: Hypothesis | null = null;
  private isLost = false;
  private others: Hypothesis[] = [];
  private goodFixMs: number | null = null;
  // Capture times, within the history, of the fixes that have counted.
  private readonly countedMs = new Set<number>();

  /** Throws a RangeError for parameters that make no sense. */
  constructor(parameters: Partial<DriftParameters> = {}) {
    this.parameters = { ...DEFAULT_PARAMETERS, ...parameters };
    validateParameters(this.parameters);
    this.history = new TrackHistory(this.parameters);
    this.shown = new ShownWorld(this.parameters);
  }

  get state(): DriftState {
    if (this.world !== null) return this.isLost ? 'lost' : 'locked';
    return this.others.length > 0 ? 'tentative' : 'searching';
  }

  /**
   * The device's tracking, each frame, in the order of time; on any clock that
   * never goes back. Throws a RangeError, and changes nothing, for a time that is
   * not later and for what is no pose.
   */
  track(timeMs: number, deviceFromCamera: RigidTransform): DriftEstimate {
    validatePose(timeMs, deviceFromCamera);
    const last = this.history.newest;
    if (last !== undefined && !(timeMs > last.timeMs)) {
      throw new RangeError(`${timeMs} ms is not later than ${last.timeMs} ms`);
    }
    const trackingBroke = this.history.isBroken(timeMs, deviceFromCamera);
    if (trackingBroke) this.trackingReset();
    const now = this.history.add(timeMs, deviceFromCamera);
    if (last !== undefined && !trackingBroke) {
      const drift = this.history.drift(last, now);
      this.world?.follow(last, now, drift);
      for (const other of this.others) other.follow(last, now, drift);
    }
    this.forget(timeMs);
    this.noticeLoss(timeMs);
    const passedS = last === undefined ? 0 : (timeMs - last.timeMs) / 1000;
    const snapped = this.world !== null && this.shown.step(
        this.world.pose.worldFromCamera, deviceFromCamera, passedS);
    return this.estimate(timeMs, deviceFromCamera, snapped, trackingBroke);
  }

  /**
   * A fix, as soon as the server has answered: late and out of order is fine
   * within historyS. Of several fixes of one capture time the first counts.
   * Throws a RangeError, and changes nothing, for one that is no fix.
   */
  addFix(fix: Fix): FixVerdict {
    validate(fix);
    const p = this.parameters;
    if (fix.confidence < p.minConfidence) return 'ignored_confidence';
    if (positionSigmaM(fix.covariance) > p.maxFixSigmaM ||
        rotationSigmaRad(fix.covariance) > radians(p.maxFixSigmaDeg)) {
      return 'ignored_uncertain';
    }
    const carried = this.carry(fix);
    if (carried === null) return 'ignored_untracked';
    if (this.countedMs.has(fix.captureTimeMs)) return 'ignored_repeated';
    this.countedMs.add(fix.captureTimeMs);
    if (this.world !== null && this.corrects(this.world, carried)) {
      this.world.support(carried);
      this.good(carried);
      return 'applied';
    }
    const hypothesis = this.hypothesisOf(carried);
    if (!this.wins(hypothesis)) return 'held';
    const verdict = this.world === null ? 'locked' : 'jumped';
    // What was lost is not moved: it begins anew.
    if (this.isLost) this.shown.clear();
    this.world = hypothesis;
    this.good(carried);
    return verdict;
  }

  /** Tracking began anew: poses from now on are in another device frame. */
  trackingReset(): void {
    this.history.clear();
    this.shown.clear();
    this.world = null;
    this.isLost = false;
    this.others = [];
    this.countedMs.clear();
  }

  // The fix where the camera is now.
  private carry(fix: Fix): CarriedFix | null {
    const captured = this.history.at(fix.captureTimeMs);
    const newest = this.history.newest;
    if (captured === undefined || newest === undefined) return null;
    const p = this.parameters;
    const covariance = addMatrices(fix.covariance, diagonal(
        p.fixSigmaFloorM ** 2, radians(p.fixSigmaFloorDeg) ** 2))
        .map((value) => value / fix.confidence);
    const worldFromCamera = compose(
        compose(fix.worldFromCamera, inverse(captured.deviceFromCamera)),
        newest.deviceFromCamera);
    const movedM = subtract(
        worldFromCamera.translationM, fix.worldFromCamera.translationM);
    return {
      now: {
        worldFromCamera,
        covariance: addMatrices(transported(covariance, movedM),
            this.history.drift(captured, newest)),
      },
      confidence: fix.confidence,
      captured,
    };
  }

  // Whether a fix is close enough to be believed alone.
  private corrects(world: Hypothesis, fix: CarriedFix): boolean {
    const delta = difference(
        world.pose.worldFromCamera, fix.now.worldFromCamera);
    const p = this.parameters;
    return lengthOfTranslationM(delta) <= p.maxSingleFixM &&
        angleOfRotationRad(delta) <= radians(p.maxSingleFixDeg) &&
        squaredDistance(world.pose, fix.now) <= p.worldGate;
  }

  // The hypothesis that the fix agrees with best, or a new one.
  private hypothesisOf(fix: CarriedFix): Hypothesis {
    let best: Hypothesis | null = null;
    let least = this.parameters.agreementGate;
    for (const other of this.others) {
      const distance = squaredDistance(other.pose, fix.now);
      if (distance <= least) {
        best = other;
        least = distance;
      }
    }
    if (best !== null) {
      best.support(fix);
      return best;
    }
    if (this.others.length === this.parameters.maxHypotheses) {
      const oldest = Math.min(
          ...this.others.map((other) => other.lastSupportMs));
      this.others.splice(this.others.findIndex(
          (other) => other.lastSupportMs === oldest), 1);
    }
    const created = new Hypothesis(fix, this.parameters);
    this.others.push(created);
    return created;
  }

  // Whether a hypothesis is to be the world: it has enough support, more than
  // any other.
  private wins(hypothesis: Hypothesis): boolean {
    if (this.others.some((other) => other !== hypothesis &&
        other.fixCount >= hypothesis.fixCount)) {
      return false;
    }
    const isExplained = this.world === null || this.isLost ||
        squaredDistance(this.world.pose, hypothesis.pose) <=
        this.parameters.worldGate;
    return isExplained ? hypothesis.mayLock() : hypothesis.mayContradict();
  }

  // The world has a fix: what contradicted it must begin again.
  private good(fix: CarriedFix): void {
    this.goodFixMs = Math.max(this.goodFixMs ?? -Infinity, fix.captured.timeMs);
    this.others = [];
    this.isLost = false;
  }

  // What is too old to count.
  private forget(nowMs: number): void {
    const lifetimeMs = this.parameters.hypothesisLifetimeS * 1000;
    this.others = this.others.filter(
        (other) => nowMs - other.lastSupportMs <= lifetimeMs);
    const oldestMs = this.history.oldest!.timeMs;
    for (const captureMs of this.countedMs) {
      if (captureMs < oldestMs) this.countedMs.delete(captureMs);
    }
  }

  private noticeLoss(nowMs: number): void {
    if (this.world === null || this.goodFixMs === null) return;
    const p = this.parameters;
    const { covariance } = this.world.pose;
    if (nowMs - this.goodFixMs > p.lostAfterS * 1000 ||
        positionSigmaM(covariance) > p.lostSigmaM ||
        rotationSigmaRad(covariance) > radians(p.lostSigmaDeg)) {
      this.isLost = true;
    }
  }

  private estimate(timeMs: number, deviceFromCamera: RigidTransform,
      snapped: boolean, trackingBroke: boolean): DriftEstimate {
    const worldFromDevice = this.shown.current;
    const covariance = this.world?.pose.covariance;
    return {
      state: this.state,
      worldFromDevice,
      worldFromCamera: worldFromDevice === null ? null :
        compose(worldFromDevice, deviceFromCamera),
      positionSigmaM:
          covariance === undefined ? null : positionSigmaM(covariance),
      rotationSigmaDeg: covariance === undefined ? null :
        degrees(rotationSigmaRad(covariance)),
      sinceGoodFixS: this.goodFixMs === null ? null :
        (timeMs - this.goodFixMs) / 1000,
      contradictingViews: this.world === null ? 0 :
        Math.max(0, ...this.others.map((other) =>
          other.contradictionViewCount)),
      snapped,
      trackingBroke,
    };
  }
}

function validatePose(
    timeMs: number, { rotation: q, translationM: t }: RigidTransform): void {
  if (![timeMs, q.w, q.x, q.y, q.z, t.x, t.y, t.z].every(Number.isFinite)) {
    throw new RangeError('a time or a pose has a NaN or an infinity');
  }
  if (Math.abs(Math.hypot(q.w, q.x, q.y, q.z) - 1) > 0.01) {
    throw new RangeError('the rotation of a pose has norm 1');
  }
}

function validate(fix: Fix): void {
  validatePose(fix.captureTimeMs, fix.worldFromCamera);
  if (!(fix.confidence >= 0 && fix.confidence <= 1)) {
    throw new RangeError('the confidence of a fix is in [0, 1]');
  }
  if (!isCovariance(fix.covariance)) {
    throw new RangeError('the covariance of a fix is 6x6, finite, symmetric ' +
        'and positive semidefinite');
  }
}
