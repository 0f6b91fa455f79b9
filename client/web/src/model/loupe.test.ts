import assert from 'node:assert/strict';
import { test } from 'node:test';

import { IDENTITY, type Correspondence } from '@treeline/client';

import { loupeInWords, loupeView } from './loupe.js';

const camera = { widthPx: 640, heightPx: 480, fxPx: 500, fyPx: 500,
  cxPx: 319.5, cyPx: 239.5 };
const seenAt = (xPx: number, yPx: number, inlier: boolean, x = 0, y = 0, z = 2):
    Correspondence => ({ xPx, yPx, inlier, pointInWorldM: { x, y, z },
      pointInCameraM: { x, y, z } });

test('a loupe shows the points under it, and where they should be', () => {
  const view = loupeView({ camera, worldFromCamera: IDENTITY,
    correspondences: [seenAt(320, 240, true), seenAt(330, 240, false, 0.2),
      seenAt(360, 240, true)] }, { xPx: 322, yPx: 241 }, 30);
  assert.deepEqual(view.points, [
    { at: { xPx: 320, yPx: 240 }, expected: { xPx: 319.5, yPx: 239.5 },
      agrees: true },
    { at: { xPx: 330, yPx: 240 }, expected: { xPx: 369.5, yPx: 239.5 },
      agrees: false }]);
  assert.equal(loupeInWords(view), '1 of 2 pixels agree here.');
});

test('a pixel agrees if one of the points that were found for it does', () => {
  const view = loupeView({ camera, worldFromCamera: IDENTITY,
    correspondences: [seenAt(10, 10, false, 1), seenAt(10, 10, true),
      seenAt(10, 10, false, 1)] }, { xPx: 10, yPx: 10 }, 5);
  assert.equal(loupeInWords(view), '1 of 1 pixels agree here.');
  assert.equal(view.points[0]!.expected!.xPx, 319.5);
});

test('a point behind the camera is expected nowhere', () => {
  const view = loupeView({ camera, worldFromCamera: IDENTITY,
    correspondences: [seenAt(10, 10, false, 0, 0, -1)] },
  { xPx: 10, yPx: 10 }, 5);
  assert.equal(view.points[0]!.expected, null);
});

test('where nothing was looked at, that is said', () => {
  assert.match(loupeInWords({ points: [], agreeing: 0 }), /No pixel/);
});
