// The corrector does what client/fusion_vectors say. The folder is named by
// TREELINE_FUSION_VECTORS.

import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';

import { norm, subtract } from '../geometry/vector3.js';
import { expectedOf, fixOfEvent, parametersOf, poseOf,
  type ExpectedEstimate, type Vectors } from '../testing/fusion_vectors.js';
import { DriftCorrector } from './drift_corrector.js';

const FOLDER = process.env['TREELINE_FUSION_VECTORS'];
const TOLERANCE = 1e-6;

// The same words, and numbers within the tolerance.
function checkNear(actual: unknown, expected: unknown, where: string): void {
  if (typeof expected === 'number' && typeof actual === 'number') {
    assert.ok(Math.abs(actual - expected) <= TOLERANCE,
        `${where}: ${actual} is not ${expected}`);
  } else if (Array.isArray(expected) && Array.isArray(actual)) {
    assert.equal(actual.length, expected.length, where);
    expected.forEach((value, i) =>
      checkNear(actual[i], value, `${where}[${i}]`));
  } else {
    assert.deepEqual(actual, expected, where);
  }
}

function checkEstimate(actual: ExpectedEstimate, expected: ExpectedEstimate,
    where: string): void {
  assert.deepEqual(Object.keys(actual).sort(), Object.keys(expected).sort());
  for (const [name, value] of Object.entries(expected)) {
    checkNear(actual[name as keyof ExpectedEstimate], value,
        `${where}: ${name}`);
  }
}

// Replays a file; returns how many times a claim was put to the test.
function replay(vectors: Vectors): number {
  const corrector = new DriftCorrector(parametersOf(vectors));
  let claimed = 0;
  vectors.events.forEach((event, i) => {
    const where = `event ${i}`;
    switch (event.kind) {
      case 'reset':
        corrector.trackingReset();
        assert.equal(corrector.state, event.expect.state, where);
        break;
      case 'fix':
        assert.equal(corrector.addFix(fixOfEvent(event)),
            event.expect.verdict, where);
        assert.equal(corrector.state, event.expect.state, where);
        break;
      case 'track': {
        const estimate = corrector.track(
            event.time_ms, poseOf(event.device_from_camera));
        checkEstimate(expectedOf(estimate), event.expect, where);
        if (estimate.state !== 'locked') return;
        const truth = poseOf(event.true_world_from_camera);
        const errorM = norm(subtract(
            estimate.worldFromCamera!.translationM, truth.translationM));
        for (const claim of vectors.claims) {
          if (event.time_ms < claim.from_ms || event.time_ms > claim.to_ms) {
            continue;
          }
          claimed += 1;
          assert.ok(errorM <= claim.max_error_m,
              `${where} at ${event.time_ms} ms: ${errorM} m from the truth`);
        }
        break;
      }
    }
  });
  return claimed;
}

test('the vectors are where they should be', () => {
  assert.ok(FOLDER, 'TREELINE_FUSION_VECTORS is not set');
  assert.ok(readdirSync(FOLDER).length >= 13);
});

for (const file of FOLDER === undefined ? [] : readdirSync(FOLDER)) {
  if (!file.endsWith('.json')) continue;
  test(`${file}: the same states, and near the truth`, () => {
    const vectors: Vectors =
        JSON.parse(readFileSync(join(FOLDER!, file), 'utf8'));
    assert.ok(replay(vectors) > 10);
  });
}
