// The device's own tracking of the last seconds, and how uncertain it becomes.

import { interpolate, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { angleBetweenRad } from '../geometry/rotation.js';
import { norm, subtract } from '../geometry/vector3.js';
import { diagonal } from './gaussian_pose.js';
import { radians, type DriftParameters } from './parameters.js';

export interface TrackedPose {
  readonly timeMs: number;
  readonly deviceFromCamera: RigidTransform;
  /** Since tracking began. */
  readonly movedM: number;
  readonly turnedRad: number;
}

export class TrackHistory {
  private samples: TrackedPose[] = [];

  constructor(private readonly parameters: DriftParameters) {}

  get oldest(): TrackedPose | undefined {
    return this.samples[0];
  }

  get newest(): TrackedPose | undefined {
    return this.samples.at(-1);
  }

  clear(): void {
    this.samples = [];
  }

  /** Whether a sample cannot be the continuation of what came before. */
  isBroken(timeMs: number, deviceFromCamera: RigidTransform): boolean {
    const last = this.newest;
    if (last === undefined) return false;
    const passedS = (timeMs - last.timeMs) / 1000;
    const { movedM, turnedRad } = between(last, deviceFromCamera);
    return passedS > this.parameters.maxGapS ||
        movedM > this.parameters.maxSpeedMps * passedS ||
        turnedRad > radians(this.parameters.maxTurnDegps) * passedS;
  }

  /** A sample later than all others. */
  add(timeMs: number, deviceFromCamera: RigidTransform): TrackedPose {
    const last = this.newest;
    const step = last === undefined ? { movedM: 0, turnedRad: 0 } :
      between(last, deviceFromCamera);
    const sample = {
      timeMs,
      deviceFromCamera,
      movedM: (last?.movedM ?? 0) + step.movedM,
      turnedRad: (last?.turnedRad ?? 0) + step.turnedRad,
    };
    this.samples.push(sample);
    const oldestMs = timeMs - this.parameters.historyS * 1000;
    const first = this.samples.findIndex((other) => other.timeMs >= oldestMs);
    if (first > 0) this.samples.splice(0, first);
    return sample;
  }

  /** Where the camera was; undefined before the first and after the last. */
  at(timeMs: number): TrackedPose | undefined {
    const next = this.samples.findIndex((sample) => sample.timeMs >= timeMs);
    const after = this.samples[next];
    if (after === undefined || after.timeMs === timeMs) return after;
    const before = this.samples[next - 1];
    if (before === undefined) return undefined;
    const t = (timeMs - before.timeMs) / (after.timeMs - before.timeMs);
    return {
      timeMs,
      deviceFromCamera: interpolate(
          before.deviceFromCamera, after.deviceFromCamera, t),
      movedM: before.movedM + t * (after.movedM - before.movedM),
      turnedRad: before.turnedRad + t * (after.turnedRad - before.turnedRad),
    };
  }

  /** Covariance of the drift between two moments: it grows with the way. */
  drift(from: TrackedPose, to: TrackedPose): number[] {
    const movedM = to.movedM - from.movedM;
    const turnedRad = to.turnedRad - from.turnedRad;
    const passedS = (to.timeMs - from.timeMs) / 1000;
    const p = this.parameters;
    return diagonal(
        p.driftMPerSqrtM ** 2 * movedM + p.driftMPerSqrtS ** 2 * passedS,
        radians(p.driftDegPerSqrtM) ** 2 * movedM +
        radians(p.driftDegPerSqrtRad) ** 2 * turnedRad +
        radians(p.driftDegPerSqrtS) ** 2 * passedS);
  }
}

const between = (from: TrackedPose, deviceFromCamera: RigidTransform) => ({
  movedM: norm(subtract(deviceFromCamera.translationM,
      from.deviceFromCamera.translationM)),
  turnedRad: angleBetweenRad(
      from.deviceFromCamera.rotation, deviceFromCamera.rotation),
});
