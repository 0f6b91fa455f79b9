import assert from 'node:assert/strict';
import { test } from 'node:test';
import { answersOf, sumOf } from './confusion.js';
import type { RecognitionQuery } from './report_data.js';
import { recognitionFixture } from './testing_fixtures.js';

test('answers without a pose and errors are not localized', () => {
  const report = recognitionFixture();
  const [known, foreign] = report.queries as
    [RecognitionQuery, RecognitionQuery];
  assert.deepEqual(answersOf(known, report), [1, 1, 2]);
  assert.deepEqual(answersOf(foreign, report), [0, 0, 1]);
});

test('of ranks alone the first of the ranking is the answer', () => {
  const report = { ...recognitionFixture(), rank_only: true };
  const [known, foreign] = report.queries as
    [RecognitionQuery, RecognitionQuery];
  assert.deepEqual(answersOf(known, report), [2, 1, 1]);
  assert.deepEqual(answersOf(foreign, report), [1, 0, 0]);
});

test('the sum is of known scenes alone', () => {
  const sum = sumOf(recognitionFixture().queries);
  assert.equal(sum.frames, 4);
  assert.equal(sum.right_localized, 1);
  assert.equal(sum.wrong_localized, 1);
  assert.equal(sum.mean_tried, 1.25);
  assert.equal(sumOf([]).mean_tried, 0);
});
