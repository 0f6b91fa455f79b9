// Report pages in a real browser, from disk: all sections, nothing asked of
// anybody, hostile names only text.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';

import { assertWhole, drawn, fixture, folder, headings, open } from
  '../page/report_file.js';

async function unfold(page) {
  await page.evaluate(() => {
    for (const each of document.querySelectorAll('details')) each.open = true;
  });
  await drawn(page);
}

const OF_A_METHOD = ['How far off', 'Frame by frame',
  'Away from the training frames', 'Pictures', 'Where the camera was',
  'How fast', 'The hardest frames'];
const OF_ALL = ['By distance from the training frames', 'Changed pictures',
  'Before the pose', 'What options buy', 'Is the confidence calibrated',
  'Pictures from elsewhere', 'What others published'];

function single() {
  const data = fixture('evaluation');
  data.methods.length = 1;
  return data;
}

test('a page of one method has all its sections', async (t) => {
  const { page, wrongs } = await open(t, single());
  await unfold(page);
  assert.deepEqual(await headings(page),
      [...OF_A_METHOD, ...OF_ALL, 'Where this comes from']);
  assert.equal(await page.title(), 'redkitchen – Treeline');
  assert.match(await page.locator('.lede').textContent(),
      /^24 of 32 frames were placed within 5 cm and 5°\./);
  assert.deepEqual(await page.locator('.tile b').allTextContents(),
      ['75.0 %', '28.1 %', '3.20 cm', '3.3 ms', '2.0 MB']);
  // Two cumulative, two of errors, two views and a turntable, latency, scene
  // coordinates, splits, four of a sweep, confidence.
  assert.equal(await page.locator('svg.chart').count(), 15);
  assert.equal(await page.locator('svg.photo').count(), 3);
  assert.equal(await page.locator('path.inlier').first().getAttribute('d'),
      'M10 20h0');
  assert.equal(await page.locator('path.outlier').first().getAttribute('d'),
      'M30 40h0');
  assert.match(await page.locator('main').textContent(),
      /1 estimate lies outside this picture\./);
  await assertWhole(page);
  assert.deepEqual(wrongs, []);
});

test('a page of several compares them and folds each up', async (t) => {
  const { page, wrongs } = await open(t, fixture('evaluation'));
  await unfold(page);
  const all = await headings(page);
  assert.deepEqual(all.slice(0, 3),
      ['Side by side', 'By distance from the training frames',
        'Changed pictures']);
  assert.equal(all.at(-1), 'Where this comes from');
  // The one that failed has nothing to unfold.
  assert.equal(await page.locator('details.method').count(), 2);
  assert.equal(all.filter((title) => title === 'How far off').length, 2);
  const failed = page.locator('tr', { hasText: 'no <model>' }).first();
  assert.match(await failed.textContent(), /^failedno <model>$/);
  assert.ok(await page.locator('td.best').count() > 0);
  await assertWhole(page);
  assert.deepEqual(wrongs, []);
});

test('a page of recognition has the matrix', async (t) => {
  const { page, wrongs } = await open(t, fixture('recognition'));
  assert.deepEqual(await headings(page), ['Confusion matrix', 'In figures',
    'How fast', 'Where this comes from']);
  assert.deepEqual(await page.locator('.matrix tbody tr').allTextContents(),
      ['kitchen112', 'builtin1']);
  await assertWhole(page);
  assert.deepEqual(wrongs, []);
});

test('hostile names are text', async (t) => {
  const data = single();
  const evil = '</script><script>alert(1)</script><img src=x onerror=alert(2)>';
  data.dataset = `7scenes:${evil}`;
  data.command = evil;
  data.cpu = evil;
  data.methods[0].name = evil;
  data.methods[0].per_frame[31].stem = evil;
  data.methods[0].page.heat_maps[0].stem = evil;
  data.methods[0].foreign[0].accepted_names = [evil];
  data.methods[0].page.model_description[0].rows[0][1] = evil;
  const { page, wrongs } = await open(t, data);
  await unfold(page);
  assert.equal(await page.locator('pre').textContent(), evil);
  assert.equal(await page.locator('img[src=x]').count(), 0);
  assert.equal(await page.locator('script').count(), 2);
  assert.ok((await page.locator('main').textContent()).includes(evil));
  assert.deepEqual(wrongs, []);
});

test('no script but the template\'s own runs', async (t) => {
  const { page } = await open(t, single());
  await page.evaluate(() => {
    const script = document.createElement('script');
    script.textContent = 'window.wasRun = true';
    document.body.append(script);
  });
  assert.equal(await page.evaluate(() => window.wasRun), undefined);
});

test('the turntable turns', async (t) => {
  const { page, wrongs } = await open(t, single());
  const chart = page.locator('.turntable svg.chart');
  await chart.waitFor();
  const before = await chart.innerHTML();
  await page.locator('.turntable input').fill('90');
  assert.notEqual(await chart.innerHTML(), before);
  assert.deepEqual(wrongs, []);
});

test('a dot says which frame it is', async (t) => {
  const { page } = await open(t, single());
  const section = page.locator('section', { hasText: 'Frame by frame' });
  const dot = section.locator('g[data-mark=dot] circle').nth(4);
  await dot.hover({ force: true });
  await section.getByText('seq-01/frame-4: 1.0 cm').waitFor();
});

for (const [name, options] of [
  ['a phone', { viewport: { width: 360, height: 740 } }],
  ['the dark', { colorScheme: 'dark' }]]) {
  test(`a page fits ${name}`, async (t) => {
    const { page, wrongs } = await open(t, fixture('evaluation'), options);
    await unfold(page);
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

test('paper shows what is folded up', async (t) => {
  const { page, wrongs } = await open(t, fixture('evaluation'));
  await page.emulateMedia({ media: 'print' });
  await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
  assert.equal(await page.locator('details[open]').count(), 2);
  assert.equal(await page.locator('.drawing:not(:has(svg))').count(), 0);
  await page.evaluate(() => window.dispatchEvent(new Event('afterprint')));
  assert.equal(await page.locator('details[open]').count(), 0);
  assert.deepEqual(wrongs, []);
});

test('the template by itself shows a file of data', async (t) => {
  const { page, wrongs } = await open(t, null);
  const file = path.join(folder, 'result.data.json');
  fs.writeFileSync(file, 'no report');
  await page.locator('input[type=file]').setInputFiles(file);
  await page.getByRole('alert').waitFor();
  fs.writeFileSync(file, JSON.stringify(single()));
  await page.locator('input[type=file]').setInputFiles(file);
  await page.locator('main[data-shown=evaluation]').waitFor();
  assert.deepEqual((await headings(page)).slice(0, 1), ['How far off']);
  assert.deepEqual(wrongs, []);
});

test('every kind of run makes a page', async (t) => {
  const changes = {
    'no frame': (method) => { method.per_frame = []; method.scored = 0;
      method.frames = 0; },
    'no ground truth': (method) => {
      method.scored = 0;
      for (const frame of method.per_frame) {
        Object.assign(frame, { true_world_from_camera: null,
          translation_error_m: null, rotation_error_deg: null,
          training_distance: null });
      }
    },
    'one frame without error': (method) => {
      method.per_frame.length = 1;
      Object.assign(method.per_frame[0],
          { translation_error_m: 0, rotation_error_deg: 0 });
    },
    'all lost': (method) => {
      for (const frame of method.per_frame) {
        Object.assign(frame, { outcome: 'NOT_LOCALIZED',
          world_from_camera: null, translation_error_m: null,
          rotation_error_deg: null });
      }
    },
  };
  for (const [name, change] of Object.entries(changes)) {
    const data = single();
    data.methods[0].page.pictures = [];
    change(data.methods[0]);
    const { page, wrongs } = await open(t, data);
    await unfold(page);
    assert.equal((await headings(page)).at(-1), 'Where this comes from', name);
    await assertWhole(page);
    assert.deepEqual(wrongs, [], name);
  }
  const failed = fixture('evaluation');
  failed.methods = failed.methods.slice(2);
  const { page, wrongs } = await open(t, failed);
  assert.deepEqual(wrongs, []);
  assert.equal((await headings(page))[0], 'Side by side');
});
