import assert from 'node:assert/strict';
import { test } from 'node:test';
import { accuracyColumns, costColumns, falseAccepts, inputsText, isBest }
  from './columns.js';
import { evaluated } from './report_data.js';
import { evaluationFixture } from './testing_fixtures.js';

const methods = evaluated(evaluationFixture());
const [rgbd, other] = methods as [typeof methods[0], typeof methods[0]];

test('the best of a column is the greatest share and the least error', () => {
  const columns = accuracyColumns(rgbd.thresholds.map(({ name }) => name));
  assert.deepEqual(columns.map((column) => column.title), ['5 cm / 5°',
    '2 cm / 2°', '10 cm / 10°', 'median cm', 'median °', 'ATE cm',
    'localized']);
  for (const column of columns) {
    assert.ok(isBest(column, other, methods), column.title);
    assert.ok(!isBest(column, rgbd, methods), column.title);
  }
});

test('equal values are best together, and missing ones never', () => {
  const [p50] = costColumns(methods);
  assert.ok(p50);
  assert.ok(isBest(p50, rgbd, [rgbd, rgbd]));
  const unknown = { ...rgbd, latency_ms: { p50: null, p95: null, p99: null } };
  assert.ok(!isBest(p50, unknown, [rgbd, unknown]));
  assert.ok(isBest(p50, rgbd, [rgbd, unknown]));
});

test('false accepts are counted where pictures were asked about', () => {
  assert.equal(falseAccepts(rgbd), 2);
  assert.equal(falseAccepts({ ...rgbd, foreign: [] }), null);
  assert.equal(costColumns([{ ...rgbd, foreign: [] }]).length, 6);
  assert.equal(costColumns(methods).at(-1)?.title, 'false accepts');
});

test('inputs are those of training and of a query', () => {
  assert.equal(inputsText(rgbd), 'RGB-D / RGB-D');
  assert.equal(inputsText({ ...rgbd,
    page: { ...rgbd.page, inputs: null } }), '–');
});
