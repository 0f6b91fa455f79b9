import assert from 'node:assert/strict';
import test from 'node:test';

import { cholesky, multiplyMatrices, solveCholesky, transpose } from
  './matrix.js';
import {
  compose, fromColumnMajor4, IDENTITY, interpolate, inverse, toColumnMajor4,
  transformPoint, type RigidTransform,
} from './rigid_transform.js';
import { angleBetweenRad, fromAxisAngle, rotate, slerp, toAxisAngle } from
  './rotation.js';

const closeTo = (actual: number, expected: number, tolerance = 1e-12) =>
  assert.ok(Math.abs(actual - expected) <= tolerance,
      `${actual} is not ${expected}`);

const TURN: RigidTransform = {
  rotation: fromAxisAngle({ x: 0.3, y: -0.5, z: 0.2 }),
  translationM: { x: 1, y: -2, z: 3 },
};

test('a quarter turn about z takes x to y', () => {
  const turned = rotate(
      fromAxisAngle({ x: 0, y: 0, z: Math.PI / 2 }), { x: 1, y: 0, z: 0 });
  closeTo(turned.x, 0);
  closeTo(turned.y, 1);
});

test('Log undoes Exp, for no angle, small and large ones', () => {
  for (const angleRad of [0, 1e-12, 1e-8, 1e-4, 1, 3, Math.PI - 1e-6]) {
    const axis = toAxisAngle(fromAxisAngle(
        { x: 0.6 * angleRad, y: 0, z: -0.8 * angleRad }));
    closeTo(axis.x, 0.6 * angleRad, 1e-9 * Math.max(angleRad, 1e-6));
    closeTo(axis.z, -0.8 * angleRad, 1e-9 * Math.max(angleRad, 1e-6));
  }
});

test('a transform and its inverse give the identity', () => {
  const same = compose(TURN, inverse(TURN));
  closeTo(angleBetweenRad(same.rotation, IDENTITY.rotation), 0);
  closeTo(same.translationM.x, 0);
  closeTo(same.translationM.y, 0);
  closeTo(same.translationM.z, 0);
});

test('a product maps points as one after the other does', () => {
  const second: RigidTransform = {
    rotation: fromAxisAngle({ x: -1, y: 0.1, z: 2 }),
    translationM: { x: 0.1, y: 0.2, z: 0.3 },
  };
  const point = { x: 4, y: 5, z: 6 };
  const once = transformPoint(compose(TURN, second), point);
  const twice = transformPoint(TURN, transformPoint(second, point));
  closeTo(once.x, twice.x);
  closeTo(once.y, twice.y);
  closeTo(once.z, twice.z);
});

test('matrices are read from columns, whichever way they are turned', () => {
  // About x, y, z by nearly half a turn: each branch of the conversion.
  for (const axis of [{ x: 3, y: 0.1, z: 0 }, { x: 0, y: 3, z: 0.1 },
    { x: 0.1, y: 0, z: 3 }, { x: 0.1, y: 0.2, z: 0.3 }]) {
    const transform = { rotation: fromAxisAngle(axis),
      translationM: { x: 7, y: 8, z: 9 } };
    const back = fromColumnMajor4(toColumnMajor4(transform));
    closeTo(angleBetweenRad(back.rotation, transform.rotation), 0, 1e-9);
    assert.deepEqual(back.translationM, transform.translationM);
  }
  assert.throws(() => fromColumnMajor4([1, 2, 3]), RangeError);
});

test('the middle of two poses is half the way and half the angle', () => {
  const middle = interpolate(IDENTITY, TURN, 0.5);
  closeTo(middle.translationM.y, -1);
  closeTo(angleBetweenRad(middle.rotation, TURN.rotation),
      angleBetweenRad(IDENTITY.rotation, TURN.rotation) / 2);
  // The shorter arc, though w changes its sign.
  const there = fromAxisAngle({ x: 0, y: 0, z: 3 });
  const here = fromAxisAngle({ x: 0, y: 0, z: -3 });
  closeTo(angleBetweenRad(slerp(there, here, 0.5), there), Math.PI - 3, 1e-9);
});

test('a Cholesky solution solves', () => {
  const a = [4, 2, 0.5, 2, 3, 1, 0.5, 1, 2];
  const l = cholesky(a, 3);
  assert.ok(l);
  multiplyMatrices(l, transpose(l, 3), 3).forEach((value, i) =>
    closeTo(value, a[i]!));
  // a * (1, -2, 3) by hand: 4 - 4 + 1.5, 2 - 6 + 3, 0.5 - 2 + 6.
  const x = solveCholesky(l, [1.5, -1, 4.5]);
  [1, -2, 3].forEach((value, i) => closeTo(x[i]!, value));
  assert.equal(cholesky([1, 2, 2, 1], 2), null);
});
