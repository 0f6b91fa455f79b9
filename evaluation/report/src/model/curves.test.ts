import assert from 'node:assert/strict';
import { test } from 'node:test';
import { cumulative, errorDomain, errorDots, histogram, logTicks, roundStep,
  shareBelow, valueRange } from './curves.js';
import { firstMethod } from './testing_fixtures.js';

test('a curve counts what has no value in the total', () => {
  assert.deepEqual(cumulative([7, 1.5, 1], 4, 5),
      [{ x: 0, y: 0 }, { x: 1, y: 0.25 }, { x: 1.5, y: 0.5 },
        { x: 5, y: 0.5 }]);
  assert.equal(shareBelow([1, 1.5, 7], 4, 2), 0.5);
  assert.deepEqual(cumulative([], 0, 5), [{ x: 0, y: 0 }, { x: 5, y: 0 }]);
});

test('a curve of many values keeps its ends', () => {
  const many = Array.from({ length: 100_000 }, (_, i) => i / 100_000);
  const curve = cumulative(many, 200_000, 1);
  assert.ok(curve.length < 500);
  assert.deepEqual(curve.at(-1), { x: 1, y: 0.5 });
});

test('a histogram counts what lies beyond in its last bin', () => {
  const { bins, end, beyond } =
    histogram([...new Array<number>(1000).fill(1), 500]);
  assert.equal(beyond, 1);
  assert.ok(end >= 1.25 && end < 2);
  assert.deepEqual(bins.map((bin) => bin.count), [1000, 1]);
  assert.equal(bins.at(-1)?.to, end);
  assert.deepEqual(histogram([]).bins, []);
});

test('steps are 1, 2 or 5 times a power of ten', () => {
  assert.deepEqual([0.7, 1, 1.2, 2.1, 5, 6, 30, 0.03].map(roundStep),
      [1, 1, 2, 5, 5, 10, 50, 0.05]);
});

test('one lucky frame does not stretch the axis of errors', () => {
  const errors = [1e-9, ...new Array<number>(500).fill(3)];
  const [low, high] = errorDomain(errors, [2, 5]);
  assert.ok(low > 1.5 && low < 2);
  assert.ok(high > 5 && high < 6);
  const [least, most] = errorDomain([], []);
  assert.ok(least > 0 && most > least);
});

test('a logarithmic axis has round ticks', () => {
  assert.deepEqual(logTicks([0.3, 12]), [0.5, 1, 2, 5, 10]);
  assert.deepEqual(logTicks([0.5, 9000]), [1, 10, 100, 1000]);
});

test('lines keep their limit and are not flattened', () => {
  assert.deepEqual(valueRange([], 100), [0, 1]);
  assert.deepEqual(valueRange([100], 100), [85 + 14.25, 100]);
  assert.equal(valueRange([10, 50])[0], 0);
  assert.ok(valueRange([97, 98])[0] > 90);
  assert.deepEqual(valueRange([0]), [0, 1]);
});

test('frames without ground truth have no dot, lost ones a cross', () => {
  const method = firstMethod();
  const dots = errorDots(method.per_frame, (_, index) => index);
  assert.equal(dots.placed.length, 31);
  assert.deepEqual(dots.lost.map((dot) => dot.x), [31]);
  const away = errorDots(method.per_frame, () => null);
  assert.equal(away.placed.length + away.lost.length, 0);
});
