import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import { parseBench, type BenchData } from './bench_data.js';
import { courseDots, heaviestKept, highestThroughput, loadName, loadPoints,
  offerPoints, round, stageParts } from './curves.js';

function fixture(): BenchData {
  const data = parseBench(fs.readFileSync('fixtures/ramp.json', 'utf8'));
  if (typeof data === 'string') throw new Error(data);
  return data;
}

test('what is no result is refused in words', () => {
  assert.equal(parseBench('{'), 'This is no JSON.');
  for (const text of ['null', '7', '[]', '{"kind":"evaluation"}',
    '{"kind":"bench"}']) {
    assert.match(parseBench(text) as string, /no result/);
  }
});

test('latency goes by throughput, three percentiles a run', () => {
  const points = loadPoints(fixture().runs);
  assert.equal(points.length, 9);
  assert.deepEqual(points[2], { run: 0, percentile: 'p99',
    throughput_per_s: 20, latency_ms: 14 });
  const silent = fixture().runs.slice(0, 1);
  silent[0]!.latency_ms = null;
  assert.deepEqual(loadPoints(silent), []);
});

test('an offer is told by what became of it', () => {
  const points = offerPoints(fixture().runs);
  assert.deepEqual(points.slice(8).map((each) => [each.what, each.per_s]),
      [['answered', 48], ['turned away', 30], ['too late', 2], ['failed', 0]]);
});

test('stages add up to the round trip', () => {
  const parts = stageParts(fixture().runs).filter((part) => part.run === 0);
  assert.deepEqual(parts.map((part) => part.mean_ms),
      [0.5, 3, 2, 1, 1.5, 0.5, 1]);
});

test('a server without timings has no stages', () => {
  const runs = fixture().runs;
  for (const run of runs) run.server = { total_ms: null };
  assert.deepEqual(stageParts(runs), []);
});

test('the course has gaps where nothing was answered', () => {
  const dots = courseDots(fixture());
  assert.deepEqual(dots[0], { at_s: 0, run: 0, answers_per_s: 20, p99_ms: 14 });
  assert.equal(dots.at(-1)?.p99_ms, null);
  assert.ok((dots.at(-1)?.at_s ?? 0) > 20);
});

test('the heaviest load without a failure is told', () => {
  const data = fixture();
  assert.equal(heaviestKept(data), '40/s');
  data.fail_if = [];
  assert.equal(heaviestKept(data), null);
  for (const run of data.runs) run.failures = ['p99 is high'];
  data.fail_if = ['p99>1ms'];
  assert.equal(heaviestKept(data), null);
  assert.equal(highestThroughput(data.runs)?.rate_per_s, 80);
  assert.equal(highestThroughput([]), null);
});

test('loads have names', () => {
  const run = fixture().runs[0]!;
  assert.equal(loadName(run), '20/s');
  assert.equal(loadName({ ...run, loop: 'closed', concurrency: 1 }), '1 client');
  assert.equal(loadName({ ...run, loop: 'closed', concurrency: 8,
    stream_window: 4 }), '8 clients, streams of 4');
  assert.equal(round(12.34), '12.3');
  assert.equal(round(123.4), '123');
});
