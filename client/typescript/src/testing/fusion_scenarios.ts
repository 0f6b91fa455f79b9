// Walks with tracking that drifts and a server that errs, by seed: what the
// vectors of client/fusion_vectors are made of.

import type { Fix } from '../fusion/drift_corrector.js';
import { diagonal, moved } from '../fusion/gaussian_pose.js';
import { radians, type DriftParameters } from '../fusion/parameters.js';
import { cholesky, multiplyMatrices, transpose } from '../geometry/matrix.js';
import { compose, inverse, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { fromAxisAngle, multiply, normalized } from '../geometry/rotation.js';

export type Event =
  { readonly kind: 'track', readonly timeMs: number,
    readonly deviceFromCamera: RigidTransform,
    readonly trueWorldFromCamera: RigidTransform } |
  { readonly kind: 'fix', readonly fix: Fix } |
  { readonly kind: 'reset' };

/** While locked between two moments, the shown camera is this near the truth. */
export interface Claim {
  readonly fromMs: number;
  readonly toMs: number;
  readonly maxErrorM: number;
}

export interface Scenario {
  readonly name: string;
  readonly description: string;
  readonly parameters: Partial<DriftParameters>;
  readonly events: readonly Event[];
  readonly claims: readonly Claim[];
}

// Uniform in [0, 1) and normal numbers of a seed.
class Chance {
  constructor(private state: number) {}

  uniform(): number {
    this.state = (Math.imul(this.state, 1664525) + 1013904223) >>> 0;
    return this.state / 2 ** 32;
  }

  normal(): number {
    return Math.sqrt(-2 * Math.log(1 - this.uniform())) *
        Math.cos(2 * Math.PI * this.uniform());
  }
}

const STEP_MS = 200;
// As many digits as the files have, so that they hold what was computed with.
const rounded = (value: number): number => Math.round(value * 1e9) / 1e9;

function roundedTransform({ rotation: q, translationM: t }: RigidTransform):
    RigidTransform {
  return {
    rotation: { w: rounded(q.w), x: rounded(q.x), y: rounded(q.y),
      z: rounded(q.z) },
    translationM: { x: rounded(t.x), y: rounded(t.y), z: rounded(t.z) },
  };
}

// x right, y down, z forward of a level camera that looks along the world's x.
const LEVEL = normalized({ w: 0.5, x: -0.5, y: 0.5, z: -0.5 });

const posed = (x: number, y: number, z: number, yawRad: number) => ({
  rotation: multiply(fromAxisAngle({ x: 0, y: 0, z: yawRad }), LEVEL),
  translationM: { x, y, z },
});

/** About a table at 0.8 m/s, looking around. */
function walk(timeMs: number): RigidTransform {
  const s = timeMs / 1000;
  const angle = 0.8 * s / 3;
  return posed(3 * Math.cos(angle), 2 * Math.sin(angle),
      1.5 + 0.05 * Math.sin(5 * s), angle + Math.PI / 2 + 0.4 * Math.sin(s));
}

/** In hand, nearly still: breath and a few degrees. */
const stand = (timeMs: number): RigidTransform => posed(
    1 + 0.01 * Math.sin(timeMs / 700), 2, 1.5,
    0.01 * Math.sin(timeMs / 900));

interface FixOptions {
  /** Of the truth. */
  readonly error?: readonly number[];
  readonly sigmaM?: number;
  readonly confidence?: number;
}

class Recording {
  readonly events: Event[] = [];
  private readonly chance: Chance;
  private worldFromDevice: RigidTransform;
  private timeMs = 0;

  constructor(seed: number,
      private readonly path: (timeMs: number) => RigidTransform,
      private readonly driftPerStepM = 0.001) {
    this.chance = new Chance(seed);
    this.worldFromDevice = posed(4, -1, 0.3, 1.1);
  }

  /** Tracks until `untilMs`; `onTime` is called after each pose. */
  track(untilMs: number, onTime: (timeMs: number) => void = () => {}): void {
    for (; this.timeMs <= untilMs; this.timeMs += STEP_MS) {
      const truth = this.path(this.timeMs);
      this.drift(truth, this.driftPerStepM);
      this.events.push({ kind: 'track', timeMs: this.timeMs,
        deviceFromCamera: roundedTransform(
            compose(inverse(this.worldFromDevice), truth)),
        trueWorldFromCamera: roundedTransform(truth) });
      onTime(this.timeMs);
    }
  }

  fix(captureMs: number, options: FixOptions = {}): void {
    const { error = [0, 0, 0, 0, 0, 0], sigmaM = 0.01, confidence = 0.97 } =
        options;
    const covariance = this.covariance(sigmaM);
    const lower = cholesky(covariance, 6)!;
    const normals = error.map(() => this.chance.normal());
    const noise = error.map((value, i) => value + normals.reduce(
        (sum, normal, k) => sum + lower[6 * i + k]! * normal, 0));
    this.events.push({ kind: 'fix', fix: { captureTimeMs: captureMs,
      worldFromCamera: roundedTransform(moved(this.path(captureMs), noise)),
      covariance, confidence } });
  }

  reset(): void {
    this.events.push({ kind: 'reset' });
    this.worldFromDevice = posed(-2, 5, 1, -2);
  }

  /** Tracking slips, as a device does that sees nothing for a moment. */
  slip(delta: readonly number[]): void {
    const truth = this.path(this.timeMs);
    this.worldFromDevice = compose(
        moved(truth, delta), inverse(compose(
            inverse(this.worldFromDevice), truth)));
  }

  // The true worldFromDevice moves; seen from the camera, by so much.
  private drift(truth: RigidTransform, lengthM: number): void {
    const turnRad = lengthM / 10;
    const delta = Array.from({ length: 6 }, (_, i) =>
      (i < 3 ? lengthM : turnRad) * this.chance.normal());
    this.worldFromDevice = compose(
        moved(truth, delta), inverse(compose(
            inverse(this.worldFromDevice), truth)));
  }

  // Longer along one direction than along others, and position coupled with
  // rotation, as those of real answers.
  private covariance(sigmaM: number): number[] {
    const turn = radians(0.3);
    const mixing = Array.from({ length: 36 }, (_, i) =>
      0.3 * this.chance.normal() * (i < 18 ? sigmaM : turn));
    const mixed = multiplyMatrices(mixing, transpose(mixing, 6), 6);
    const base = diagonal((0.6 * sigmaM) ** 2, (0.6 * turn) ** 2);
    return mixed.map((value, i) =>
      Math.round((value + base[i]!) * 1e12) / 1e12);
  }
}

const everySecond = (timeMs: number) => timeMs % 1000 === 0;

function cleanWalk(): Scenario {
  const r = new Recording(1, walk);
  r.track(20_000, (timeMs) => {
    if (everySecond(timeMs) && timeMs >= 1000) r.fix(timeMs - 300);
  });
  return { name: 'clean_walk', parameters: {}, events: r.events,
    description: 'A walk; a right fix each second, 0.3 s late.',
    claims: [{ fromMs: 2000, toMs: 20_000, maxErrorM: 0.06 }] };
}

function singleLie(): Scenario {
  const r = new Recording(2, walk);
  r.track(20_000, (timeMs) => {
    if (!everySecond(timeMs) || timeMs < 1000) return;
    const isLie = timeMs === 8000;
    r.fix(timeMs - 300, isLie ?
      { error: [3, -2, 0, 0, 0, 1], confidence: 0.99 } : {});
  });
  return { name: 'single_lie', parameters: {}, events: r.events,
    description: 'One fix at 8 s is 3.6 m and 57 degrees wrong, and sure.',
    claims: [{ fromMs: 2000, toMs: 20_000, maxErrorM: 0.06 }] };
}

function lieFirst(): Scenario {
  const r = new Recording(3, walk);
  r.track(12_000, (timeMs) => {
    if (!everySecond(timeMs) || timeMs < 1000) return;
    r.fix(timeMs - 300, timeMs === 1000 ?
      { error: [-2, 1, 0.5, 0, 0, -0.5], confidence: 0.99 } : {});
  });
  return { name: 'lie_first', parameters: {}, events: r.events,
    description: 'The very first fix is wrong: the world begins with those ' +
        'that agree.',
    claims: [{ fromMs: 0, toMs: 12_000, maxErrorM: 0.06 }] };
}

function lyingBurst(): Scenario {
  const r = new Recording(4, (timeMs) =>
    timeMs < 6000 ? walk(timeMs) : walk(6000 + (timeMs - 6000) / 50));
  const lie = [2, 2, 0, 0, 0, 0.7];
  r.track(20_000, (timeMs) => {
    if (!everySecond(timeMs) || timeMs < 1000) return;
    r.fix(timeMs - 300, timeMs > 7000 && timeMs < 14_000 ?
      { error: lie, confidence: 0.98 } : {});
  });
  return { name: 'agreeing_lies_one_view', parameters: {}, events: r.events,
    description: 'From 8 to 13 s the device stands, and six fixes in a row ' +
        'tell the same lie: one view is no proof against the world.',
    claims: [{ fromMs: 2000, toMs: 20_000, maxErrorM: 0.06 }] };
}

function overconfident(): Scenario {
  const r = new Recording(5, stand);
  r.track(24_000, (timeMs) => {
    if (!everySecond(timeMs) || timeMs < 1000) return;
    const isLie = timeMs === 12_000 || timeMs === 16_000;
    r.fix(timeMs - 200, isLie ?
      { error: [0.14, 0, 0, 0, 0, 0], sigmaM: 0.0005, confidence: 1 } : {});
  });
  return { name: 'overconfident_lie', parameters: {}, events: r.events,
    description: 'A device in hand. Two fixes say half a millimetre and are ' +
        '14 cm wrong.',
    claims: [{ fromMs: 5000, toMs: 24_000, maxErrorM: 0.04 }] };
}

function weakFixes(): Scenario {
  const r = new Recording(6, walk);
  r.track(20_000, (timeMs) => {
    if (!everySecond(timeMs) || timeMs < 1000) return;
    const confidence = timeMs % 3000 === 0 ? 0.4 : 0.7;
    r.fix(timeMs - 300, { confidence,
      sigmaM: timeMs === 11_000 ? 0.9 : 0.05 });
  });
  return { name: 'weak_fixes', parameters: {}, events: r.events,
    description: 'Fixes of confidence 0.7: more of them must agree. Those of ' +
        '0.4 and an uncertain one are ignored.',
    claims: [{ fromMs: 0, toMs: 20_000, maxErrorM: 0.2 }] };
}

function announcedReset(): Scenario {
  const r = new Recording(7, walk);
  const fixes = (timeMs: number) => {
    if (everySecond(timeMs) && timeMs >= 1000) r.fix(timeMs - 300);
  };
  r.track(8000, fixes);
  r.reset();
  // Captured before the reset: of no use.
  r.fix(7900);
  r.track(16_000, fixes);
  return { name: 'announced_reset', parameters: {}, events: r.events,
    description: 'Tracking begins anew at 8 s and says so; a fix of a picture ' +
        'from before is ignored.',
    claims: [{ fromMs: 2000, toMs: 16_000, maxErrorM: 0.06 }] };
}

function brokenTracking(): Scenario {
  const r = new Recording(8, walk);
  const fixes = (timeMs: number) => {
    if (everySecond(timeMs) && timeMs >= 1000) r.fix(timeMs - 300);
  };
  r.track(8000, fixes);
  r.slip([5, 0, 0, 0, 0, 0]);
  r.track(16_000, fixes);
  return { name: 'broken_tracking', parameters: {}, events: r.events,
    description: 'Tracking jumps by 5 m at 8 s without a word: faster than ' +
        'anybody moves.',
    claims: [{ fromMs: 2000, toMs: 16_000, maxErrorM: 0.06 }] };
}

function slippedTracking(): Scenario {
  const r = new Recording(9, walk);
  const fixes = (timeMs: number) => {
    if (everySecond(timeMs) && timeMs >= 1000) r.fix(timeMs - 300);
  };
  r.track(8000, fixes);
  r.slip([0.5, 0.3, 0, 0, 0, 0.1]);
  r.track(32_000, fixes);
  return { name: 'slipped_tracking', parameters: {}, events: r.events,
    description: 'Tracking slips by 0.6 m and 6 degrees at 8 s, unnoticed. ' +
        'Fixes contradict the world from three views and win; what is shown ' +
        'moves there without a step.',
    claims: [{ fromMs: 2000, toMs: 8000, maxErrorM: 0.06 },
      { fromMs: 8000, toMs: 28_000, maxErrorM: 0.9 },
      { fromMs: 28_000, toMs: 32_000, maxErrorM: 0.06 }] };
}

function lateFixes(): Scenario {
  const r = new Recording(10, walk);
  const lateMs = [300, 2500, 900, 4100, 700, 1700, 3300];
  r.track(25_000, (timeMs) => {
    if (!everySecond(timeMs) || timeMs < 5000) return;
    r.fix(timeMs - lateMs[timeMs / 1000 % lateMs.length]!);
    if (timeMs === 15_000) r.fix(timeMs - 12_000);
  });
  return { name: 'late_and_out_of_order', parameters: {}, events: r.events,
    description: 'Fixes are 0.3 to 4.1 s late and come out of order; one is ' +
        'older than the history.',
    claims: [{ fromMs: 7000, toMs: 25_000, maxErrorM: 0.08 }] };
}

function repeatedFixes(): Scenario {
  const r = new Recording(13, walk);
  const lie = [2, 2, 0, 0, 0, 0.7];
  r.track(12_000, (timeMs) => {
    if (!everySecond(timeMs) || timeMs < 1000) return;
    const error = timeMs === 1000 || timeMs === 7000 ? lie : undefined;
    for (let i = 0; i < 4; ++i) {
      r.fix(timeMs - 300, error === undefined ? {} : { error });
    }
  });
  return { name: 'repeated_fixes', parameters: {}, events: r.events,
    description: 'Each picture is answered four times: a picture counts once. ' +
        'The first, and one later, are wrong.',
    claims: [{ fromMs: 2000, toMs: 12_000, maxErrorM: 0.06 }] };
}

function lossAndReturn(): Scenario {
  const r = new Recording(11, walk, 0.03);
  r.track(30_000, (timeMs) => {
    if (!everySecond(timeMs) || timeMs < 1000) return;
    if (timeMs <= 6000 || timeMs >= 24_000) r.fix(timeMs - 300);
  });
  return { name: 'drift_loss_and_return', events: r.events,
    parameters: { lostAfterS: 12, snapM: 0.5 },
    description: 'Tracking drifts fast and nobody answers from 6 to 24 s: the ' +
        'world is lost, and found again.',
    // It drifts by 12 cm a second, faster than what is shown may follow.
    claims: [{ fromMs: 2000, toMs: 7000, maxErrorM: 0.4 },
      { fromMs: 26_000, toMs: 30_000, maxErrorM: 0.4 }] };
}

function lossByUncertainty(): Scenario {
  const r = new Recording(12, walk, 0.004);
  r.track(24_000, (timeMs) => {
    if (!everySecond(timeMs) || timeMs < 1000) return;
    if (timeMs <= 5000 || timeMs >= 20_000) r.fix(timeMs - 300);
  });
  return { name: 'loss_by_uncertainty', events: r.events,
    parameters: { lostSigmaM: 0.08 },
    description: 'The way without a fix alone makes the world too uncertain.',
    claims: [{ fromMs: 2000, toMs: 6000, maxErrorM: 0.08 }] };
}

export const scenarios = (): Scenario[] => [cleanWalk(), singleLie(),
  lieFirst(), lyingBurst(), overconfident(), weakFixes(), announcedReset(),
  brokenTracking(), slippedTracking(), lateFixes(), repeatedFixes(),
  lossAndReturn(), lossByUncertainty()];
