// Report pages as files in a real browser.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before } from 'node:test';
import { pathToFileURL } from 'node:url';

import { assertAccessible } from './accessibility.js';
import { launch } from './browser.js';

const TEMPLATE = fs.readFileSync(process.env.TREELINE_REPORT_TEMPLATE, 'utf8');
export const folder =
  fs.mkdtempSync(path.join(os.tmpdir(), 'treeline-report-'));
let browser = null;

before(async () => {
  browser = await launch(process.env.TREELINE_REPORT_WORK);
});
after(async () => {
  await browser?.close();
  fs.rmSync(folder, { recursive: true });
});

export function fixture(name) {
  return JSON.parse(fs.readFileSync(
      path.join(process.env.TREELINE_REPORT_FIXTURES, `${name}.json`), 'utf8'));
}

// As common/page/page_template.cc fills it.
function filled(data) {
  const parts = TEMPLATE.split('"@REPORT_DATA@"');
  assert.equal(parts.length, 2);
  return parts.join(JSON.stringify(data).replaceAll('<', '\\u003c'));
}

// The page of some data, with what it did wrong. null: the template itself.
export async function open(t, data, options = {}) {
  const file = path.join(folder, 'page.html');
  fs.writeFileSync(file, data === null ? TEMPLATE : filled(data));
  const context = await browser.newContext(
      { viewport: { width: 1200, height: 900 }, ...options });
  t.after(() => context.close());
  const page = await context.newPage();
  const wrongs = [];
  page.on('pageerror', (error) => wrongs.push(`error: ${error.message}`));
  page.on('dialog', (dialog) => {
    wrongs.push(`dialog: ${dialog.message()}`);
    void dialog.dismiss();
  });
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type())) {
      wrongs.push(`${message.type()}: ${message.text()}`);
    }
  });
  page.on('request', (request) => {
    const url = request.url();
    if (!url.startsWith('file:') && !url.startsWith('data:')) {
      wrongs.push(`asked ${url}`);
    }
  });
  await page.goto(pathToFileURL(file).href);
  return { page, wrongs };
}

// Charts are drawn when they have a width.
export async function drawn(page) {
  await page.waitForFunction(() =>
    [...document.querySelectorAll('.drawing')].every((each) =>
      each.querySelector('svg') !== null));
}

export const headings = (page) => page.locator('h2').allTextContents();

// No chart says NaN, and nobody forgot a figure.
export async function assertWhole(page) {
  const odd = await page.evaluate(() => {
    const found = [];
    const shown = document.querySelector('main');
    if (/\b(NaN|undefined|null|Infinity|\[object)\b/.test(shown.textContent)) {
      found.push(shown.textContent.match(
          /.{0,40}\b(NaN|undefined|null|Infinity|\[object)\b.{0,20}/)[0]);
    }
    for (const each of shown.querySelectorAll('svg, svg *')) {
      for (const { name, value } of each.attributes) {
        if (/NaN|undefined|Infinity/.test(value)) found.push(`${name}=${value}`);
      }
    }
    return found;
  });
  assert.deepEqual(odd, []);
  await assertAccessible(page, process.env.TREELINE_REPORT_WORK);
}
