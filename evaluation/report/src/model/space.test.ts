import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Axes, Point, Pose } from './report_data.js';
import { boxOf, contains, dot, fromAbove, frustum, thinned, toWorld, truePaths,
  turned, withTruth, type TrueFrame } from './space.js';
import { firstMethod, frameAt } from './testing_fixtures.js';

const half = Math.sqrt(0.5);
// A quarter turn about z, at (1, 2, 3).
const pose: Pose = { qw: half, qx: 0, qy: 0, qz: half, tx: 1, ty: 2, tz: 3 };
const axes: Axes = { right: [1, 0, 0], forward: [0, 1, 0], up: [0, 0, 1] };

function near(a: number[], b: number[]): void {
  assert.equal(a.length, b.length);
  a.forEach((value, i) => {
    assert.ok(Math.abs(value - (b[i] as number)) < 1e-9, `${a} is not ${b}`);
  });
}

test('a pose takes points of the camera into the world', () => {
  near(toWorld(pose, [1, 0, 0]), [1, 3, 3]);
  near(toWorld(pose, [0, 0, 5]), [1, 2, 8]);
});

test('the axes of the fixture are orthonormal', () => {
  const { right, forward, up } = firstMethod().page.axes;
  for (const axis of [right, forward, up]) near([dot(axis, axis)], [1]);
  near([dot(right, forward), dot(right, up), dot(up, forward)], [0, 0, 0]);
});

test('a full turn of the turntable changes nothing', () => {
  const point: Point = [0.3, -0.4, 0.5];
  near(turned(axes, [1, 1, 1], 2 * Math.PI)(point),
      turned(axes, [1, 1, 1], 0)(point));
  // The middle stays where it is.
  near(turned(axes, [1, 1, 1], 0.7)([1, 1, 1]), [0, 0]);
});

test('a pyramid has four edges and a rim', () => {
  const segments = frustum(pose, 2, fromAbove(axes));
  assert.equal(segments.length, 8);
  assert.equal(segments.filter(({ from }) =>
    Math.abs(from[0] - 1) + Math.abs(from[1] - 2) < 1e-12).length, 4);
});

test('a path is cut where the recording went on elsewhere', () => {
  const frame = frameAt(firstMethod(), 0);
  const at = (x: number): TrueFrame =>
    ({ ...frame, true_world_from_camera: { ...pose, tx: x } });
  const paths = truePaths([0, 0.1, 0.2, 0.3, 5, 5.1, 5.2].map(at));
  assert.deepEqual(paths.map((path) => path.length), [4, 3]);
  assert.deepEqual(truePaths([]), []);
  assert.equal(withTruth(firstMethod().per_frame).length, 32);
});

test('a box holds its points and no others', () => {
  const box = boxOf([[0, 0], [2, 1]], 0.5);
  assert.ok(contains(box, [2.4, 1.4]));
  assert.ok(!contains(box, [2.6, 1]));
});

test('few of a list are all of it', () => {
  assert.deepEqual(thinned([1, 2, 3], 14), [1, 2, 3]);
  assert.equal(thinned(Array.from({ length: 300 }, (_, i) => i), 14).length,
      15);
});
