import assert from 'node:assert/strict';
import { test } from 'node:test';
import { parseReport } from './report_data.js';
import { evaluationFixture, firstMethod } from './testing_fixtures.js';
import { comparisonVerdict, methodVerdict } from './verdict.js';

test('the verdict counts what was placed, lost and not read', () => {
  // Errors are 2 mm, 4 mm, ...: 24 are below 5 cm.
  assert.equal(methodVerdict(firstMethod()),
      '24 of 32 frames were placed within 5 cm and 5°. 1 more has no ground ' +
      'truth. One was given up as not localized. 1 could not be read or used.');
});

test('the verdict says so where there is no ground truth', () => {
  const method = { ...firstMethod(), scored: 0, frames: 5, localized: 5,
    errors: 0 };
  assert.equal(methodVerdict(method),
      '5 of 5 frames were localized; the recording has no ground truth to ' +
      'score them by. None was given up as not localized.');
});

test('a comparison names the best and counts the failed', () => {
  const { methods } = evaluationFixture();
  const other = methods[1]?.name;
  assert.equal(comparisonVerdict(methods),
      `3 methods side by side. Most accurate: ${other}, with 100 % of 20 ` +
      'frames within 5 cm and 5°. 1 could not be evaluated.');
  assert.equal(comparisonVerdict(methods.slice(2)),
      '1 method side by side. 1 could not be evaluated.');
});

test('what is no report is refused in words', () => {
  assert.match(parseReport('{') as string, /no JSON/);
  for (const text of ['null', '3', '"@REPORT_DATA@"', '{}', '{"kind":"x"}']) {
    assert.match(parseReport(text) as string, /no report/);
  }
  assert.equal(typeof parseReport('{"kind":"evaluation"}'), 'object');
});
