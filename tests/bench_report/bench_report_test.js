// Reports of load tests in a real browser, from disk: all sections, nothing
// asked of anybody, hostile names only text.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';

import { assertWhole, drawn, fixture, folder, headings, open } from
  '../page/report_file.js';

const ramp = () => fixture('ramp');

test('a ramp has all its sections', async (t) => {
  const { page, wrongs } = await open(t, ramp());
  await drawn(page);
  assert.deepEqual(await headings(page), ['Verdict', 'Latency by throughput',
    'What was offered, and what became of it', 'Where the time goes', 'Course',
    'The server', 'Run by run', 'Errors', 'Where this comes from']);
  assert.equal(await page.locator('svg.chart').count(), 9);
  assert.match(await page.locator('.lede').textContent(),
      /^1400 calls over gRPC from 2 processes, in 3 runs\./);
  assert.deepEqual(await page.locator('.tile b').allTextContents(),
      ['48/s', '190 ms', '40/s', '22.9 %', '1', '0']);
  assert.match(await page.locator('main').textContent(),
      /80\/s: p99 is 190\.00 ms \(p99>50ms\); wrong is 1 \(wrong>0\)/);
  assert.match(await page.locator('main').textContent(), /QUEUE_FULL/);
  await assertWhole(page);
  assert.deepEqual(wrongs, []);
});

test('a dot says which run it is', async (t) => {
  const { page } = await open(t, ramp());
  await drawn(page);
  const section = page.locator('section', { hasText: 'Latency by throughput' });
  const dot = section.locator('g[data-mark=dot] circle').last();
  await dot.hover({ force: true });
  await section.getByText('fails: p99 is 190.00 ms').waitFor();
});

test('hostile names are text', async (t) => {
  const data = ramp();
  const evil = '</script><script>alert(1)</script><img src=x onerror=alert(2)>';
  data.server = evil;
  data.target = evil;
  data.machine.cpu = evil;
  data.workload[0].scene = evil;
  data.fail_if = [evil];
  data.runs[2].failures = [evil];
  data.runs[2].outcomes[1].reason = evil;
  data.server_metrics.version = evil;
  data.server_metrics.missed = 1;
  data.server_metrics.last_error = evil;
  const { page, wrongs } = await open(t, data);
  await drawn(page);
  assert.equal(await page.locator('img').count(), 0);
  assert.equal(await page.locator('script').count(), 2);
  assert.ok((await page.locator('main').textContent()).includes(evil));
  assert.deepEqual(wrongs, []);
});

test('every kind of run makes a page', async (t) => {
  const changes = {
    'no run at all': (data) => { data.runs = []; data.server_metrics = null; },
    'one closed loop': (data) => {
      data.runs.length = 1;
      Object.assign(data.runs[0],
          { loop: 'closed', rate_per_s: null, concurrency: 8 });
      data.fail_if = [];
      data.server_metrics = null;
    },
    'nothing answered': (data) => {
      for (const run of data.runs) {
        run.latency_ms = null;
        run.answers_per_s = 0;
        run.counts.ok = 0;
        run.intervals = [];
        for (const name of Object.keys(run.server)) run.server[name] = null;
      }
      data.server_metrics.points = [];
    },
  };
  for (const [name, change] of Object.entries(changes)) {
    const data = ramp();
    change(data);
    const { page, wrongs } = await open(t, data);
    await drawn(page);
    assert.equal((await headings(page)).at(-1), 'Where this comes from', name);
    await assertWhole(page);
    assert.deepEqual(wrongs, [], name);
  }
});

for (const [name, options] of [
  ['a phone', { viewport: { width: 360, height: 740 } }],
  ['the dark', { colorScheme: 'dark' }]]) {
  test(`a page fits ${name}`, async (t) => {
    const { page, wrongs } = await open(t, ramp(), options);
    await drawn(page);
    const [wide, window_] = await page.evaluate(() =>
      [document.documentElement.scrollWidth, innerWidth]);
    assert.ok(wide <= window_, `${wide} px on ${window_}`);
    // Letters keep their size: charts are drawn, not shrunk.
    const ratios = await page.locator('svg.chart').evaluateAll((charts) =>
      charts.map((each) => each.getBoundingClientRect().width /
        each.viewBox.baseVal.width));
    assert.ok(ratios.every((ratio) => ratio > 0.97), `${ratios}`);
    const paper = await page.evaluate(() =>
      getComputedStyle(document.body).backgroundColor);
    assert.equal(paper === 'rgb(18, 22, 26)', name === 'the dark');
    assert.deepEqual(wrongs, []);
  });
}

test('the template by itself shows a file of data', async (t) => {
  const { page, wrongs } = await open(t, null);
  const file = path.join(folder, 'run.json');
  fs.writeFileSync(file, '{"kind":"evaluation"}');
  await page.locator('input[type=file]').setInputFiles(file);
  await page.getByRole('alert').waitFor();
  fs.writeFileSync(file, JSON.stringify(ramp()));
  await page.locator('input[type=file]').setInputFiles(file);
  await page.locator('main[data-shown=bench]').waitFor();
  assert.deepEqual(wrongs, []);
});
