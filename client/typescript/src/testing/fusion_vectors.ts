// The files of client/fusion_vectors, to and from values.

import { DriftCorrector, type DriftEstimate, type Fix } from
  '../fusion/drift_corrector.js';
import { DEFAULT_PARAMETERS, type DriftParameters } from
  '../fusion/parameters.js';
import { normalized } from '../geometry/rotation.js';
import type { RigidTransform } from '../geometry/rigid_transform.js';
import type { Scenario } from './fusion_scenarios.js';

/** qw, qx, qy, qz, tx, ty, tz. */
export type PoseNumbers = readonly number[];

export interface ExpectedEstimate {
  readonly state: string;
  readonly world_from_device: PoseNumbers | null;
  readonly position_sigma_m: number | null;
  readonly rotation_sigma_deg: number | null;
  readonly since_good_fix_s: number | null;
  readonly contradicting_views: number;
  readonly snapped: boolean;
  readonly tracking_broke: boolean;
}

export type VectorEvent =
  { readonly kind: 'track', readonly time_ms: number,
    readonly device_from_camera: PoseNumbers,
    readonly true_world_from_camera: PoseNumbers,
    readonly expect: ExpectedEstimate } |
  { readonly kind: 'fix', readonly capture_time_ms: number,
    readonly world_from_camera: PoseNumbers,
    readonly covariance: readonly number[], readonly confidence: number,
    readonly expect: { readonly verdict: string, readonly state: string } } |
  { readonly kind: 'reset', readonly expect: { readonly state: string } };

export interface Vectors {
  readonly description: string;
  readonly parameters: Readonly<Record<string, number>>;
  readonly claims: readonly { readonly from_ms: number,
    readonly to_ms: number, readonly max_error_m: number }[];
  readonly events: readonly VectorEvent[];
}

const rounded = (value: number): number => Math.round(value * 1e9) / 1e9;
const roundedOrNull = (value: number | null): number | null =>
  value === null ? null : rounded(value);

const numbersOf = ({ rotation: q, translationM: t }: RigidTransform):
    PoseNumbers => [q.w, q.x, q.y, q.z, t.x, t.y, t.z].map(rounded);

export function poseOf(numbers: PoseNumbers): RigidTransform {
  const [w, x, y, z, tx, ty, tz] = numbers as [number, number, number, number,
    number, number, number];
  return { rotation: normalized({ w, x, y, z }),
    translationM: { x: tx, y: ty, z: tz } };
}

export const fixOfEvent = (
    event: VectorEvent & { readonly kind: 'fix' }): Fix => ({
  captureTimeMs: event.capture_time_ms,
  worldFromCamera: poseOf(event.world_from_camera),
  covariance: event.covariance,
  confidence: event.confidence,
});

export const expectedOf = (e: DriftEstimate): ExpectedEstimate => ({
  state: e.state,
  world_from_device:
      e.worldFromDevice === null ? null : numbersOf(e.worldFromDevice),
  position_sigma_m: roundedOrNull(e.positionSigmaM),
  rotation_sigma_deg: roundedOrNull(e.rotationSigmaDeg),
  since_good_fix_s: roundedOrNull(e.sinceGoodFixS),
  contradicting_views: e.contradictingViews,
  snapped: e.snapped,
  tracking_broke: e.trackingBroke,
});

// maxSingleFixM <-> max_single_fix_m.
const snake = (name: string): string =>
  name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);
const camel = (name: string): string =>
  name.replace(/_([a-z])/g, (_, letter: string) => letter.toUpperCase());

export const parametersOf = (vectors: Vectors): Partial<DriftParameters> =>
  Object.fromEntries(Object.entries(vectors.parameters).map(
      ([name, value]) => [camel(name), value]));

/** All parameters are written, so that a file stands for itself. */
export function vectorsOf(scenario: Scenario): Vectors {
  const parameters = { ...DEFAULT_PARAMETERS, ...scenario.parameters };
  const corrector = new DriftCorrector(parameters);
  const events = scenario.events.map((event): VectorEvent => {
    switch (event.kind) {
      case 'reset':
        corrector.trackingReset();
        return { kind: 'reset', expect: { state: corrector.state } };
      case 'fix': {
        const plain = {
          kind: 'fix' as const,
          capture_time_ms: event.fix.captureTimeMs,
          world_from_camera: numbersOf(event.fix.worldFromCamera),
          covariance: event.fix.covariance,
          confidence: event.fix.confidence,
        };
        const verdict = corrector.addFix(
            fixOfEvent({ ...plain, expect: { verdict: '', state: '' } }));
        return { ...plain, expect: { verdict, state: corrector.state } };
      }
      case 'track': {
        const numbers = numbersOf(event.deviceFromCamera);
        return {
          kind: 'track',
          time_ms: event.timeMs,
          device_from_camera: numbers,
          true_world_from_camera: numbersOf(event.trueWorldFromCamera),
          expect: expectedOf(corrector.track(event.timeMs, poseOf(numbers))),
        };
      }
    }
  });
  return {
    description: scenario.description,
    parameters: Object.fromEntries(Object.entries(parameters).map(
        ([name, value]) => [snake(name), value])),
    claims: scenario.claims.map(({ fromMs, toMs, maxErrorM }) =>
      ({ from_ms: fromMs, to_ms: toMs, max_error_m: maxErrorM })),
    events,
  };
}

/** JSON with one event a line. */
export function textOf(vectors: Vectors): string {
  const { events, ...rest } = vectors;
  const head = JSON.stringify(rest, null, 1).replace(/\n}$/, '');
  const lines = events.map((event) => JSON.stringify(event));
  return `${head},\n "events": [\n${lines.join(',\n')}\n]}\n`;
}
