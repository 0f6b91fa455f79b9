// docs/tutorials/ar-in-the-browser.md, followed word by word: its commands in a
// shell, and then what a reader does in the browser. Run by ctest
// (run_ar_tutorial.cmake) with TREELINE_PROGRAMS, TREELINE_PAGE and
// TREELINE_PAGE_WORK.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { createInterface } from 'node:readline';
import { after, test } from 'node:test';

import { launch } from '../page/browser.js';

const { TREELINE_PAGE, TREELINE_PAGE_WORK, TREELINE_PROGRAMS } = process.env;
const ROOT = path.resolve(import.meta.dirname ??
  path.dirname(new URL(import.meta.url).pathname), '../..');
const TUTORIAL = fs.readFileSync(
    path.join(ROOT, 'docs/tutorials/ar-in-the-browser.md'), 'utf8');

const folder = fs.mkdtempSync(path.join(tmpdir(), 'treeline-ar-tutorial-'));
let shell;
let browser;

after(async () => {
  await browser?.close();
  // The shell leads a group of its own.
  if (shell) process.kill(-shell.pid, 'SIGKILL');
  fs.rmSync(folder, { recursive: true });
});

// What is fenced as ```sh, in one shell, until the server says where its page
// is.
async function follow() {
  const steps = [...TUTORIAL.matchAll(/^```sh\n(.*?)^```$/gms)]
      .map(([, step]) => step);
  assert.equal(steps.length, 3);
  const checkout = path.join(folder, 'treeline');
  fs.mkdirSync(path.join(checkout, 'build'), { recursive: true });
  fs.symlinkSync(TREELINE_PAGE, path.join(checkout, 'build/ar-page'));
  shell = spawn('bash', ['-e', '-c', `${steps.join('\n')}\nwait`], {
    cwd: folder, detached: true, stdio: ['ignore', 'pipe', 'inherit'],
    env: { ...process.env, TREELINE: checkout,
      PATH: `${TREELINE_PROGRAMS}:/usr/bin:/bin` },
  });
  const said = [];
  for await (const line of createInterface({ input: shell.stdout })) {
    said.push(line);
    const match = /^ar page on (.*)$/.exec(line);
    if (match) return match[1];
  }
  throw new Error(`the server ended:\n${said.join('\n')}`);
}

// The flags and the address of the browser, as the page has them.
function browserCommand() {
  const [, command] = /^```\nchromium (.*?)^```$/ms.exec(TUTORIAL);
  const words = command.replaceAll('\\\n', ' ').replaceAll('"$PWD"', folder)
      .trim().split(/\s+/);
  return {
    flags: words.filter((word) => word.startsWith('--use-')),
    url: words.at(-1),
  };
}

// What a reader presses is in bold.
function assertBold(text) {
  assert.ok(TUTORIAL.includes(`**${text}**`), text);
}

test('its steps do what it says', async () => {
  const served = await follow();
  const { flags, url } = browserCommand();
  assert.equal(url, served);
  assert.equal(flags.length, 3);
  browser = await launch(TREELINE_PAGE_WORK, flags);
  const page = await browser.newPage(
      { viewport: { width: 1200, height: 760 }, reducedMotion: 'reduce' });
  page.setDefaultTimeout(60000);
  const start = async () => {
    await page.getByRole('button', { name: 'Start camera' }).click();
    await page.waitForFunction(() =>
      document.querySelector('#state').textContent === 'Located');
  };
  await page.goto(url);
  assertBold('Start camera');
  assertBold('Located');
  await start();
  const box = await page.locator('#target').boundingBox();
  await page.mouse.click(box.x + 0.5 * box.width, box.y + 0.45 * box.height);
  await page.fill('#note-input', 'What it is');
  assertBold('Save');
  await page.getByRole('button', { name: 'Save', exact: true }).click();
  const label = page.locator('button.label', { hasText: 'What it is' });
  await label.waitFor();
  await page.reload();
  await page.waitForFunction(() =>
    document.querySelector('#start')?.disabled === false);
  await start();
  await label.waitFor();
});
