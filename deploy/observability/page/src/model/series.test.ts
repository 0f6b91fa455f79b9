import assert from 'node:assert/strict';
import { test } from 'node:test';
import { alertsOf, latestOf, legendOf, pointsOf, secondsOf, targetsOf } from
  './series.js';
import { withUnit } from './units.js';

test('legends name labels', () => {
  assert.equal(legendOf('loads: {{result}}', { result: 'ok' }), 'loads: ok');
  assert.equal(legendOf('{{ a }}/{{b}}', { a: '1' }), '1/');
  assert.equal(legendOf('', { a: '1', b: '2' }), 'a=1 b=2');
  assert.equal(legendOf('', {}), 'value');
  assert.equal(legendOf('{{a}}', { a: '{{b}}', b: 'x' }), '{{b}}');
});

test('what is no number is a gap', () => {
  const points = pointsOf([{ metric: { s: 'x' }, values: [[1, '2.5'],
    [2, 'NaN'], [3, '+Inf']] }], '{{s}}');
  assert.deepEqual(points.map(({ value }) => value), [2.5, NaN, NaN]);
  assert.equal(points[0]!.time.getTime(), 1000);
  assert.deepEqual([...latestOf(points)], [['x', 2.5]]);
  for (const odd of [null, 7, 'x', [], [{}]]) {
    assert.deepEqual(pointsOf(odd, ''), []);
  }
});

test('alerts and targets that lack parts are shown all the same', () => {
  assert.deepEqual(alertsOf({ alerts: [{}] }), [{ name: '', state: '',
    severity: '', summary: '', advice: '' }]);
  assert.deepEqual(alertsOf(null), []);
  assert.deepEqual(targetsOf(null), { scraped: [], scrapeS: 1 });
  assert.deepEqual(targetsOf({ activeTargets: [{ labels: { instance: 'a:1',
    job: 'treeline' }, health: 'down', lastError: 'refused',
  scrapeInterval: '1m30s' }] }), { scrapeS: 90, scraped: [{ instance: 'a:1',
    job: 'treeline', isUp: false, error: 'refused' }] });
});

test('durations and units', () => {
  assert.equal(secondsOf('500ms'), 0.5);
  assert.equal(secondsOf(''), 0);
  assert.equal(withUnit(0.00265, 's'), '2.65 ms');
  assert.equal(withUnit(0, 's'), '0 s');
  assert.equal(withUnit(12, 's'), '12 s');
  assert.equal(withUnit(3 * 2 ** 20, 'bytes'), '3 MiB');
  assert.equal(withUnit(0, 'bytes'), '0 B');
  assert.equal(withUnit(0.985, 'percentunit'), '98.5 %');
  assert.equal(withUnit(43.21, 'reqps'), '43.2/s');
  assert.equal(withUnit(123456, 'short'), '123456');
});
