import assert from 'node:assert/strict';
import fs from 'node:fs';
import { test } from 'node:test';
import { filledExpression, parseDashboard, stepFor } from './panels.js';

test('what is no dashboard is refused in words', () => {
  assert.equal(parseDashboard('{'), 'This is no JSON.');
  for (const json of ['null', '7', '[]', '{}', '{"panels": [{}, 3, null]}',
    '{"panels": "x"}']) {
    assert.match(parseDashboard(json) as string, /no dashboard/);
  }
});

test('the dashboard that is shipped is drawn to the last panel', () => {
  const json = fs.readFileSync('fixtures/dashboard.json', 'utf8');
  const dashboard = parseDashboard(json);
  assert.ok(typeof dashboard !== 'string');
  assert.equal(dashboard.panels.length, JSON.parse(json).panels.length);
  for (const { title, targets } of dashboard.panels) {
    assert.notEqual(title, '');
    for (const { expr } of targets) {
      assert.doesNotMatch(filledExpression(expr, 15, 5), /\$/, title);
    }
  }
});

test('variables are filled in', () => {
  assert.equal(filledExpression('rate(a{i=~"$instance"}[$__rate_interval])',
      10, 5), 'rate(a{i=~".*"}[20s])');
  assert.equal(filledExpression('[$__rate_interval]', 60, 5), '[65s]');
});

test('a step is what a chart can show, and no shorter than a scrape', () => {
  assert.equal(stepFor(900, 5), 5);
  assert.equal(stepFor(86400, 5), 360);
});
