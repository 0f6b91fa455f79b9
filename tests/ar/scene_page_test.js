// The scene page in a real browser, against treeline-server with a scene that
// it has learned. Run by ctest (browser_test); environment as ar_page_test.js.
// With TREELINE_SCREENSHOTS=FOLDER it leaves pictures of itself there.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { heldOut, launchWithCamera, localizePicture, open, RECORDING,
  startServer, waitForState } from './fixture.js';
import { assertAccessible } from '../page/accessibility.js';

let server;
let browser;
before(async () => {
  server = await startServer('--recent-queries', '5');
  browser = await launchWithCamera();
});
after(async () => {
  await browser?.close();
  server?.kill();
});

const urlOf = (of, scene = 'room') => `${of.url}scene.html?scene=${scene}`;

const picture = (time) =>
  fs.readFileSync(path.join(RECORDING, 'rgb', `${time}.jpg`));

// Waits until what was asked for is drawn.
async function openShown(of, options, expected) {
  const opened = await open(browser, urlOf(of), options, expected);
  await waitForState(opened.page, 'Shown');
  await opened.page.evaluate(() => new Promise((resolve) =>
    requestAnimationFrame(() => requestAnimationFrame(resolve))));
  return opened;
}

// How many different colours the view has, as it is seen.
async function coloursOf(page) {
  const shot = (await page.locator('#view3d').screenshot()).toString('base64');
  return page.evaluate(async (png) => {
    const bytes = Uint8Array.from(atob(png), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(
        new Blob([bytes], { type: 'image/png' }));
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    const found = new Set();
    for (let i = 0; i < data.length; i += 4) {
      found.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
    }
    return found.size;
  }, shot);
}

test('points, path and coverage are shown, and told in words', async () => {
  const { page, wrongs, close } = await openShown(server);
  assert.match(await page.textContent('#description'),
      /^[\d,]+ points from \d+ keyframes\. Predicted for [\d.]+ m²: \d+ %/);
  assert.ok(await page.locator('#legend').isVisible());
  const all = await coloursOf(page);
  assert.ok(all > 50, `${all} colours`);
  for (const layer of ['points', 'path', 'coverage', 'queries']) {
    await page.uncheck(`#show-${layer}`);
  }
  assert.equal(await coloursOf(page), 1);
  await page.check('#show-coverage');
  assert.ok(await coloursOf(page) > 1);
  // The middle of the room is in view.
  const middle = await page.evaluate(
      () => window.treeline.shareOf(2.5, 2.5, 1));
  assert.ok(middle.x > 0.1 && middle.x < 0.9 && middle.y > 0.1 &&
      middle.y < 0.9, JSON.stringify(middle));
  assert.deepEqual(wrongs, []);
  await close();
});

test('the latest queries are listed, and why they failed', async () => {
  const { page, wrongs, close } = await openShown(server);
  assert.equal(await page.textContent('#queries-note'), 'None yet.');
  const located = await localizePicture(server, picture(heldOut[1]));
  assert.equal(located.outcome, 'OUTCOME_LOCALIZED');
  const broken = await localizePicture(server, Buffer.from('no picture'));
  assert.equal(broken.code, 'invalid_argument');
  await page.waitForFunction(() =>
    document.querySelectorAll('#queries li').length === 2);
  assert.equal(await page.textContent('#queries-note'),
      '1 located, 0 not located, 1 failed.');
  const [failed, found] = await page.locator('#queries button').all();
  assert.match(await failed.textContent(), /^Failed.*not valid/);
  assert.match(await found.textContent(), /^Located.*points agree/);
  await found.click();
  assert.equal(await found.getAttribute('aria-pressed'), 'true');
  // No more are kept than the setting says.
  for (let i = 0; i < 6; ++i) {
    await localizePicture(server, Buffer.from('no picture'));
  }
  await page.waitForFunction(() =>
    document.querySelector('#queries-note').textContent ===
        '0 located, 0 not located, 5 failed.');
  assert.deepEqual(wrongs, []);
  await close();
});

test('a server that keeps no queries says so', async () => {
  const quiet = await startServer();
  const { page, wrongs, close } = await openShown(quiet, {}, /400/);
  assert.match(await page.textContent('#queries-note'), /keeps no queries/);
  assert.deepEqual(wrongs, []);
  await close();
  quiet.kill();
});

test('everything is reached and done with the keyboard alone', async () => {
  const { page, close } = await openShown(server);
  const focused = () => page.evaluate(() => {
    const { id, tagName, parentElement } = document.activeElement;
    return id || `${tagName} ${parentElement.id}`;
  });
  const tabTo = async (id) => {
    for (let i = 0; i < 60; ++i) {
      if (await focused() === id) return;
      await page.keyboard.press('Tab');
    }
    assert.fail(`the keyboard does not reach ${id}`);
  };
  const middle = () => page.evaluate(() => window.treeline.shareOf(1, 2, 0.5));
  await tabTo('view3d');
  const before = await middle();
  for (const key of ['ArrowLeft', 'ArrowDown', '+', '-', 'Shift+ArrowUp']) {
    const was = await middle();
    await page.keyboard.press(key);
    assert.notDeepEqual(await middle(), was, key);
  }
  await page.keyboard.press('Home');
  const after = await middle();
  assert.ok(Math.hypot(after.x - before.x, after.y - before.y) < 1e-6);
  await tabTo('look-above');
  await page.keyboard.press('Enter');
  assert.notDeepEqual(await middle(), after);
  for (const id of ['nearer', 'farther', 'show-points', 'show-path',
    'show-coverage', 'show-queries', 'scene']) {
    await tabTo(id);
  }
  await close();
});

test('phones and tablets of either bearing have all of it, in either tone',
    async () => {
      const folder = process.env.TREELINE_SCREENSHOTS;
      await localizePicture(server, picture(heldOut[2]));
      await localizePicture(server, picture(heldOut[3]));
      for (const colorScheme of ['light', 'dark']) {
        for (const viewport of [{ width: 1280, height: 800 },
          { width: 820, height: 1180 }, { width: 390, height: 844 },
          { width: 844, height: 390 }]) {
          const { page, wrongs, close } =
              await openShown(server, { viewport, colorScheme });
          await page.waitForSelector('#queries li');
          const small = await page.evaluate(() => [
            ...document.querySelectorAll('button, select, summary, ' +
                'label.check, a, input:not([type=checkbox])')]
              .map((part) => ({ part, box: part.getBoundingClientRect() }))
              .filter(({ box }) => box.height > 0 &&
                  (box.height < 44 || box.width < 44))
              .map(({ part, box }) =>
                `${part.id || part.textContent}: ${box.width}x${box.height}`));
          assert.deepEqual(small, []);
          assert.ok(await page.evaluate(() =>
            document.documentElement.scrollWidth <= window.innerWidth));
          const view = await page.locator('#view3d').boundingBox();
          assert.ok(view.width >= 300 && view.height >= 200,
              JSON.stringify(view));
          assert.ok(await coloursOf(page) > 50);
          await assertAccessible(page, process.env.TREELINE_PAGE_WORK);
          if (folder) {
            await page.screenshot({ path: path.join(folder,
                `scene-${viewport.width}-${colorScheme}.png`) });
          }
          assert.deepEqual(wrongs, []);
          await close();
        }
      }
    });
