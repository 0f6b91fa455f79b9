import assert from 'node:assert/strict';
import test from 'node:test';

import { IDENTITY_ROTATION, type RecentQuery, type SceneCoverage, type SceneMap }
  from '@treeline/client';

import { ballOf, COVERAGE_ALL, COVERAGE_HALF, COVERAGE_NONE, countQueries,
  coverageColor, coveragePixels, describeMap, pointColors, pyramid } from
  './scene_picture.js';

const COVERAGE: SceneCoverage = {
  minXM: 0, minYM: 0, cellM: 0.5, columns: 3, rows: 1, headings: 16,
  heightM: 1.5, groundM: 0, isOpen: new Uint8Array([1, 0, 1]),
  goodHeadings: new Uint8Array([16, 16, 4]),
  weakHeadings: new Uint8Array([0, 0, 8]), openM2: 0.5, goodShare: 0.625,
  weakShare: 0.25,
};

const MAP: SceneMap = {
  scene: 'hall', modelVersion: '1',
  pointsInWorldM: new Float32Array([-1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4]),
  brightness: new Uint8Array([0, 255, 128, 1]), pointsInModel: 12345,
  worldFromKeyframe: [{ rotation: IDENTITY_ROTATION,
    translationM: { x: 0, y: 0, z: 0 } }],
  camera: null, planFromWorld: IDENTITY_ROTATION, coverage: null,
};

test('coverage goes from one colour through another to the third', () => {
  assert.deepEqual(coverageColor(0), COVERAGE_NONE);
  assert.deepEqual(coverageColor(0.5), COVERAGE_HALF);
  coverageColor(1).forEach((part, i) =>
    assert.ok(Math.abs(part - COVERAGE_ALL[i]!) < 1e-12));
});

test('what nothing is said of is not drawn', () => {
  const pixels = coveragePixels(COVERAGE);
  assert.deepEqual([...pixels.subarray(4, 8)], [0, 0, 0, 0]);
  assert.deepEqual([...pixels.subarray(0, 3)],
      COVERAGE_ALL.map((part) => Math.round(255 * part)));
  // A quarter good, half of it weak.
  assert.deepEqual([...pixels.subarray(8, 11)],
      COVERAGE_HALF.map((part) => Math.round(255 * part)));
});

test('points stand out from the stage', () => {
  const [black] = pointColors(new Uint8Array([0]), true);
  const [white] = pointColors(new Uint8Array([255]), false);
  assert.ok(black! >= 0.3);
  assert.ok(white! <= 0.7);
});

test('the view shows points and cameras, but for outliers', () => {
  const { centreM, radiusM } = ballOf(MAP);
  assert.deepEqual(centreM, { x: 0, y: 1, z: 2 });
  assert.equal(radiusM, Math.hypot(2, 2, 4) / 2);
  const pointsInWorldM = new Float32Array(3 * 1000);
  for (let i = 0; i < 1000; ++i) pointsInWorldM[3 * i] = i < 5 ? 1e6 : i % 10;
  assert.ok(ballOf({ ...MAP, pointsInWorldM }).radiusM < 10);
  assert.equal(ballOf({ ...MAP, pointsInWorldM: new Float32Array(),
    worldFromKeyframe: [] }).radiusM, 1);
});

test('a pyramid opens along the optical axis', () => {
  const ends = pyramid({ widthPx: 640, heightPx: 480, fxPx: 320, fyPx: 320,
    cxPx: 320, cyPx: 240 }, 0.2);
  assert.equal(ends.length, 16);
  assert.ok(ends.every(({ z }) => z === 0 || z === 0.2));
  assert.ok(ends.some(({ x, y }) => Math.abs(x + 0.2) < 1e-12 &&
      Math.abs(y + 0.15) < 1e-12));
});

test('queries are counted by what became of them', () => {
  const query = (reason: string, isError = false) =>
    ({ reason, isError }) as RecentQuery;
  assert.deepEqual(countQueries([query(''), query('TOO_FEW_INLIERS'),
    query('INVALID_REQUEST', true), query('')]),
  { located: 2, notLocated: 1, failed: 1 });
});

test('the scene is told in words', () => {
  assert.equal(describeMap(MAP), '12,345 points from 1 keyframes.');
  assert.match(describeMap({ ...MAP, coverage: COVERAGE }),
      /0\.5 m²: 63 % of the views will be answered, 25 % perhaps/);
});
