import assert from 'node:assert/strict';
import { test } from 'node:test';

import { accuracyOf } from './accuracy.js';

const covariance = (position: number[][], rotation: number[][]): number[] =>
  [0, 1, 2, 3, 4, 5].flatMap((row) => [0, 1, 2, 3, 4, 5].map((column) =>
    row < 3 && column < 3 ? position[row]![column]! :
      row >= 3 && column >= 3 ? rotation[row - 3]![column - 3]! : 0));

const diagonal = (x: number, y: number, z: number) =>
  [[x, 0, 0], [0, y, 0], [0, 0, z]];

const near = (a: number, b: number) =>
  assert.ok(Math.abs(a - b) < 1e-9, `${a} is not ${b}`);

test('it is the longest half axis', () => {
  const { positionM, rotationDeg } = accuracyOf(covariance(
      diagonal(1e-4, 4e-4, 1e-5), diagonal(1e-6, 1e-6, 1e-6)));
  near(positionM, Math.sqrt(7.815 * 4e-4));
  near(rotationDeg, Math.sqrt(7.815 * 1e-6) * 180 / Math.PI);
});

test('an axis between those of the world counts in full', () => {
  // Eigenvalues 3e-4 along (1, 1, 0), 1e-4 twice.
  const { positionM } = accuracyOf(covariance(
      [[2e-4, 1e-4, 0], [1e-4, 2e-4, 0], [0, 0, 1e-4]], diagonal(1, 1, 1)));
  near(positionM, Math.sqrt(7.815 * 3e-4));
});
