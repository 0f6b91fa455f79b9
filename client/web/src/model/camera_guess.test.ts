import assert from 'node:assert/strict';
import { test } from 'node:test';

import { answeredPinhole, correctedFieldOfViewDeg, fieldOfViewDegOf, focalPxOf,
  guessedPinhole, sentSize } from './camera_guess.js';

const near = (a: number, b: number) =>
  assert.ok(Math.abs(a - b) < 1e-9, `${a} is not ${b}`);

test('a field of view is a focal length, along the longer side', () => {
  near(focalPxOf(90, 640, 480), 320);
  near(focalPxOf(90, 480, 640), 320);
  near(fieldOfViewDegOf(320, 640, 480), 90);
});

test('the axis goes through the middle of the picture', () => {
  const { cxPx, cyPx } = guessedPinhole(65, 640, 480);
  assert.deepEqual([cxPx, cyPx], [319.5, 239.5]);
});

test('the server\'s answer corrects the guess', () => {
  const stated = guessedPinhole(65, 640, 480);
  const answered = answeredPinhole(
      stated, { camera: null, focalScale: 525 / stated.fxPx });
  near(answered.fxPx, 525);
  near(focalPxOf(correctedFieldOfViewDeg(answered), 640, 480), 525);
});

test('a lens that the server found takes the place of the guess', () => {
  const found = { model: 'SIMPLE_RADIAL', widthPx: 640, heightPx: 480,
    parameters: [525, 300, 250, -0.1] } as const;
  assert.deepEqual(
      answeredPinhole(guessedPinhole(65, 640, 480),
          { camera: found, focalScale: 1 }),
      { widthPx: 640, heightPx: 480, fxPx: 525, fyPx: 525, cxPx: 300,
        cyPx: 250 });
});

test('no answer makes a camera that there is not', () => {
  const stated = guessedPinhole(65, 640, 480);
  const corrected = (focalScale: number) =>
    correctedFieldOfViewDeg(answeredPinhole(stated, { camera: null, focalScale }));
  assert.equal(corrected(100), 20);
  assert.equal(corrected(0.01), 130);
});

test('pictures are made smaller, never larger, and keep their shape', () => {
  assert.deepEqual(sentSize(1280, 960), { widthPx: 640, heightPx: 480 });
  assert.deepEqual(sentSize(1080, 1920), { widthPx: 360, heightPx: 640 });
  assert.deepEqual(sentSize(1920, 1080), { widthPx: 640, heightPx: 360 });
  assert.deepEqual(sentSize(320, 240), { widthPx: 320, heightPx: 240 });
  assert.deepEqual(sentSize(1000, 1000), { widthPx: 480, heightPx: 480 });
});
