// Chromium for the page's tests, and what it must not do meanwhile.

import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';

const BROWSERS = [process.env.TREELINE_CHROMIUM, '/usr/bin/chromium',
  '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];

// Runs no shader on a graphics card, and asks nobody but the page's server.
const FLAGS = [
  '--no-sandbox', '--disable-gpu', '--use-gl=angle',
  '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic',
  '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync',
];

export function browserProgram() {
  return BROWSERS.find((file) => file && fs.existsSync(file)) ?? null;
}

// work: the folder whose node_modules has playwright-core.
export async function launch(work, flags = []) {
  const require = createRequire(path.resolve(work) + path.sep);
  const { chromium } = require('playwright-core');
  return chromium.launch(
      { executablePath: browserProgram(), args: [...FLAGS, ...flags] });
}

// The same as a program of its own, which can be killed.
export async function launchServer(work) {
  const require = createRequire(path.resolve(work) + path.sep);
  const { chromium } = require('playwright-core');
  const server = await chromium.launchServer(
      { executablePath: browserProgram(), args: FLAGS });
  return { browser: await chromium.connect(server.wsEndpoint()),
    kill: () => server.kill() };
}

// What the browser says of software rendering says nothing of the page.
const ABOUT_GRAPHICS = /GL Driver Message|WebGL|swiftshader/i;

// What a page of `url` does wrong from now on: errors, warnings of the console,
// and requests to other hosts. `expected`: messages that the test brings about.
export function wrongsOf(page, url, expected = null) {
  const wrongs = [];
  page.on('pageerror', (error) => wrongs.push(`error: ${error.message}`));
  page.on('console', (message) => {
    const text = message.text();
    if (!['error', 'warning'].includes(message.type())) return;
    if (ABOUT_GRAPHICS.test(text) || expected?.test(text)) return;
    wrongs.push(`${message.type()}: ${text}`);
  });
  page.on('request', (request) => {
    const to = new URL(request.url());
    if (to.protocol === 'blob:' || to.protocol === 'data:') return;
    if (to.origin !== new URL(url).origin) wrongs.push(`asked ${to.href}`);
  });
  return wrongs;
}

// A page of `url`, with what it did wrong. `onResponse` is called for each
// answer.
export async function openPage(browser, url, options = {}, expected = null,
    onResponse = () => {}) {
  const context = await browser.newContext({
    viewport: { width: 900, height: 600 }, reducedMotion: 'reduce', ...options,
  });
  // Software that draws is slow where other programs run, too.
  context.setDefaultTimeout(60000);
  const page = await context.newPage();
  const wrongs = wrongsOf(page, url, expected);
  page.on('response', onResponse);
  await page.goto(url);
  await page.waitForSelector('#map[data-map=ready]');
  return { page, wrongs, close: () => context.close() };
}

// Where a point of the map is in the window.
export function windowOf(page, x, y, z) {
  return page.evaluate((at) => window.treeline.windowOf(...at), [x, y, z]);
}

// Presses at one point of the map and lets go at another.
export async function dragOnMap(page, from, to = from) {
  const begin = await windowOf(page, ...from);
  const end = await windowOf(page, ...to);
  await page.mouse.move(begin.x, begin.y);
  await page.mouse.down();
  await page.mouse.move((begin.x + end.x) / 2, (begin.y + end.y) / 2);
  await page.mouse.move(end.x, end.y);
  await page.mouse.up();
}
