import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Correspondence, Vector3 } from '@treeline/client';

import { guessedPinhole } from './camera_guess.js';
import { pinAt, project, type LocatedPicture } from './pin.js';

// 1.5 m above the floor; looks along x of the world, level: the camera's x is
// -y, its y is -z.
const LEVEL: LocatedPicture = {
  camera: guessedPinhole(90, 640, 480),
  worldFromCamera: {
    rotation: { w: 0.5, x: -0.5, y: 0.5, z: -0.5 },
    translationM: { x: 0, y: 0, z: 1.5 },
  },
  correspondences: [],
};
const BOUNDS = { min: { x: 0, y: -5, z: 0 }, max: { x: 8, y: 5, z: 3 } };

const near = (a: Vector3, b: Vector3) => assert.ok(
    Math.hypot(a.x - b.x, a.y - b.y, a.z - b.z) < 1e-9,
    `${JSON.stringify(a)} is not ${JSON.stringify(b)}`);

const seen = (pointInWorldM: Vector3, inlier = true): Correspondence => ({
  ...project(LEVEL, pointInWorldM)!,
  pointInCameraM: { x: 0, y: 0, z: 0 }, pointInWorldM, inlier,
});

test('what is ahead is in the middle, what is behind nowhere', () => {
  assert.deepEqual(project(LEVEL, { x: 4, y: 0, z: 1.5 }),
      { xPx: 319.5, yPx: 239.5 });
  assert.deepEqual(project(LEVEL, { x: 4, y: -4, z: 1.5 }),
      { xPx: 639.5, yPx: 239.5 });
  assert.equal(project(LEVEL, { x: -4, y: 0, z: 1.5 }), null);
});

test('a pin is as far as the points around it', () => {
  const wall = [-0.1, 0, 0.1].map((y) => seen({ x: 6, y, z: 1.5 }));
  const liar = seen({ x: 2, y: 0, z: 1.5 }, false);
  const pin = pinAt({ ...LEVEL, correspondences: [...wall, liar] },
      { xPx: 319.5, yPx: 239.5 }, BOUNDS, '+z');
  assert.equal(pin?.from, 'points');
  near(pin!.pointInWorldM, { x: 6, y: 0, z: 1.5 });
});

test('one wrong point among three does not move a pin', () => {
  const points = [seen({ x: 6, y: 0.1, z: 1.5 }), seen({ x: 6, y: 0, z: 1.5 }),
    seen({ x: 2, y: 0, z: 1.5 })];
  const pin = pinAt({ ...LEVEL, correspondences: points },
      { xPx: 319.5, yPx: 239.5 }, BOUNDS, '+z');
  near(pin!.pointInWorldM, { x: 6, y: 0, z: 1.5 });
});

test('without points near it, a pin is on the floor', () => {
  const at = project(LEVEL, { x: 3, y: 1, z: 0 })!;
  const pin = pinAt(LEVEL, at, BOUNDS, '+z');
  assert.equal(pin?.from, 'floor');
  near(pin!.pointInWorldM, { x: 3, y: 1, z: 0 });
});

test('where up is -z, the floor is the upper side', () => {
  const at = project(LEVEL, { x: 3, y: 1, z: 3 })!;
  near(pinAt(LEVEL, at, BOUNDS, '-z')!.pointInWorldM, { x: 3, y: 1, z: 3 });
});

test('there is no pin on the sky, and none without a floor', () => {
  assert.equal(pinAt(LEVEL, { xPx: 320, yPx: 0 }, BOUNDS, '+z'), null);
  assert.equal(pinAt(LEVEL, { xPx: 320, yPx: 479 }, null, '+z'), null);
});
