// The AR page in a real browser, against treeline-server, with a camera that
// sees held-out frames. Run by ctest (browser_test) with TREELINE_SERVER,
// TREELINE_SCENE (make_scene.cmake), TREELINE_PAGE and TREELINE_PAGE_WORK.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { FOCAL_PX, heldOut, HEIGHT_PX, launchWithCamera, open, startServer,
  telling, trueCameraOf, trueShareOf, waitForState, WIDTH_PX } from './fixture.js';
import { assertAccessible } from '../page/accessibility.js';

// Every fourth: the walk has turned by then.
const SEEN = telling.filter((_, i) => i % 4 === 0).slice(0, 4);
const MEDIAN_PX = 3;
const TRUE_VIEW_DEG = 2 * Math.atan(WIDTH_PX / 2 / FOCAL_PX) * 180 / Math.PI;
// A focal length that is 1.5 % wrong is taken for right.
const NEAR_DEG = 0.9;

let server;
before(async () => { server = await startServer(); });
after(() => server?.kill());

// Points of the room in front of the camera, as the page draws them and as they
// are: distances in pixels of the picture.
async function errorsPx(page, time) {
  const errors = [];
  for (let x = 0.5; x < 5; x += 0.75) {
    for (let y = 0.5; y < 4.3; y += 0.75) {
      for (let z = 0.3; z < 2.6; z += 0.6) {
        const truth = trueShareOf(time, [x, y, z]);
        if (truth === null || Math.min(truth.x, truth.y) < 0 ||
            Math.max(truth.x, truth.y) > 1) {
          continue;
        }
        const drawn = await page.evaluate(
            (at) => window.treeline.shareOf(...at), [x, y, z]);
        errors.push(drawn === null ? Infinity : Math.hypot(
            (drawn.x - truth.x) * WIDTH_PX, (drawn.y - truth.y) * HEIGHT_PX));
      }
    }
  }
  return errors;
}

const median = (values) =>
  values.sort((a, b) => a - b)[Math.floor(values.length / 2)];

// The field of view that was guessed is corrected by then, or was right enough.
const settled = (page) => page.waitForFunction(() =>
  document.querySelector('#focal').textContent.includes('as stated'));

test('the world is drawn where the camera sees it', async () => {
  const all = [];
  for (const time of SEEN) {
    const browser = await launchWithCamera(time);
    const { page, wrongs } = await open(browser, server.url);
    await page.click('#start');
    await waitForState(page, 'Located');
    await settled(page);
    const view = Number.parseFloat(await page.textContent('#focal'));
    assert.ok(Math.abs(view - TRUE_VIEW_DEG) < NEAR_DEG, `${view} degrees`);
    // Of one answer, whose drawing stays.
    const errors = await errorsPx(page, time);
    assert.ok(errors.length > 10, `${time}: ${errors.length} points in view`);
    all.push(...errors);
    assert.match(await page.textContent('#accuracy'), /^[\d.]+ cm, [\d.]+°$/);
    assert.match(await page.textContent('#time'), /^\d+ ms, \d+ of it/);
    assert.deepEqual(wrongs, []);
    await browser.close();
  }
  const middle = median(all);
  console.log(`median ${middle.toFixed(2)} px of ${all.length} points`);
  assert.ok(middle <= MEDIAN_PX, `median of ${middle} px`);
});

test('a note stays where it was pinned, and is there after a reload',
    async () => {
      const browser = await launchWithCamera(SEEN[0]);
      const { page, wrongs } = await open(browser, server.url);
      await page.click('#start');
      await waitForState(page, 'Located');
      await settled(page);
      const box = await page.locator('#target').boundingBox();
      const at = { x: box.x + 0.5 * box.width, y: box.y + 0.45 * box.height };
      await page.mouse.click(at.x, at.y);
      await page.fill('#note-input', 'Here <b>it</b> is');
      await page.click('#note-save');
      const distance = async () => {
        const label = await page.locator('button.label').boundingBox();
        // The label stands above its point, by 0.8 rem.
        return Math.hypot(label.x + label.width / 2 - at.x,
            label.y + label.height + 12 - at.y);
      };
      assert.equal(await page.textContent('button.label'), 'Here <b>it</b> is');
      assert.ok(await distance() < 6, `${await distance()} px`);
      await page.reload();
      await page.click('#start:enabled');
      await waitForState(page, 'Located');
      await settled(page);
      await page.waitForSelector('button.label:visible');
      assert.ok(await distance() < 6, `${await distance()} px`);
      await page.click('#notes button');
      await page.click('#note-delete');
      await page.waitForSelector('#notes li', { state: 'detached' });
      await page.reload();
      assert.equal(await page.locator('#notes li').count(), 0);
      assert.deepEqual(wrongs, []);
      await browser.close();
    });

// A minute of a walk: held-out frames, a second each. What is drawn is compared
// with where the frame that was answered shows the place of the note.
const MINUTE_MS = 60_000;
const NEAR_M = 0.01;
// The rest is for pictures taken while the film went on to the next frame.
const NEAR_SHARE = 0.95;

test('a note stays at its place for a minute, wherever the camera goes',
    async () => {
      const browser = await launchWithCamera(...heldOut);
      const { page, wrongs } = await open(browser, server.url);
      await page.click('#start');
      await waitForState(page, 'Located');
      await page.click('#pin');
      await page.waitForSelector('dialog[open]');
      await page.fill('#note-input', 'Here');
      await page.click('#note-save');
      const [note] = await page.evaluate(() =>
        JSON.parse(localStorage.getItem('treeline.ar.notes.room')));
      const { x, y, z } = note.pointInWorldM;
      const errorsM = [];
      const end = Date.now() + MINUTE_MS;
      let seen = 0;
      while (Date.now() < end) {
        await page.waitForFunction((answers) =>
          window.treeline.answers() > answers, seen);
        const drawn = await page.evaluate((at) => ({
          answers: window.treeline.answers(),
          position: window.treeline.position(),
          share: window.treeline.shareOf(...at) }), [x, y, z]);
        seen = drawn.answers;
        if (drawn.position === null || drawn.share === null) continue;
        const away = ({ position }) => Math.hypot(
            position.x - drawn.position.x, position.y - drawn.position.y,
            position.z - drawn.position.z);
        const time = heldOut.reduce((best, each) =>
          away(trueCameraOf(each)) < away(trueCameraOf(best)) ? each : best);
        const truth = trueShareOf(time, [x, y, z]);
        if (truth === null || Math.min(truth.x, truth.y) < 0 ||
            Math.max(truth.x, truth.y) > 1) {
          continue;
        }
        const { position } = trueCameraOf(time);
        const distanceM =
            Math.hypot(x - position.x, y - position.y, z - position.z);
        errorsM.push(distanceM / FOCAL_PX * Math.hypot(
            (drawn.share.x - truth.x) * WIDTH_PX,
            (drawn.share.y - truth.y) * HEIGHT_PX));
      }
      const middle = median(errorsM);
      const within = errorsM.filter((error) => error <= NEAR_M).length;
      console.log(`note: median ${(100 * middle).toFixed(2)} cm, ` +
          `${within} of ${errorsM.length} within 1 cm, ${seen} answers`);
      assert.ok(errorsM.length >= 20, `${errorsM.length} times in view`);
      assert.ok(within >= NEAR_SHARE * errorsM.length,
          `${within} of ${errorsM.length} within 1 cm`);
      assert.deepEqual(wrongs, []);
      await browser.close();
    });

test('pictures go over one WebSocket, or are calls where there is none',
    async () => {
      const browser = await launchWithCamera(SEEN[0]);
      for (const isBlocked of [false, true]) {
        const { page, wrongs, close } = await open(browser, server.url, {},
            null, isBlocked ? () => { delete window.WebSocket; } : () => {});
        let sockets = 0;
        let calls = 0;
        page.on('websocket', () => { sockets += 1; });
        page.on('request', (request) => {
          if (request.url().endsWith('/Localize')) calls += 1;
        });
        await page.click('#start');
        await waitForState(page, 'Located');
        await page.waitForFunction(() => window.treeline.answers() >= 4);
        assert.equal(sockets, isBlocked ? 0 : 1);
        assert.equal(calls > 0, isBlocked);
        assert.deepEqual(wrongs, []);
        await close();
      }
      await browser.close();
    });

test('the model\'s points and keyframes are drawn over the picture',
    async () => {
      const browser = await launchWithCamera(SEEN[0]);
      const { page, wrongs } = await open(browser, server.url);
      await page.click('#start');
      await waitForState(page, 'Located');
      await page.uncheck('#show-grid');
      await page.uncheck('#show-box');
      const drawn = async () => (await page.locator('#frame').screenshot())
          .toString('base64');
      const plain = await drawn();
      const response = page.waitForResponse(/GetSceneMap/);
      await page.check('#show-cloud');
      assert.equal((await response).status(), 200);
      await page.waitForFunction(() => window.treeline.hasMap());
      const withPoints = await drawn();
      assert.notEqual(withPoints, plain);
      await page.check('#show-keyframes');
      assert.notEqual(await drawn(), withPoints);
      await page.uncheck('#show-cloud');
      await page.uncheck('#show-keyframes');
      assert.equal(await page.textContent('#layer-message'), '');
      assert.match(await page.getAttribute('#scene-link', 'href'),
          /^scene\.html\?scene=room$/);
      assert.deepEqual(wrongs, []);
      await browser.close();
    });

test('the loupe shows which pixels agree, under the mouse and the keys',
    async () => {
      const browser = await launchWithCamera(SEEN[0]);
      const { page, wrongs } = await open(browser, server.url, {},
          // Of how this test reads the canvas.
          /willReadFrequently/);
      await page.click('#start');
      await waitForState(page, 'Located');
      await settled(page);
      assert.equal(await page.locator('#loupe').isVisible(), false);
      await page.check('#show-loupe');
      const box = await page.locator('#target').boundingBox();
      // Somewhere several points agree.
      let best = 0;
      for (const [x, y] of [0.2, 0.4, 0.6, 0.8].flatMap((across) =>
        [0.25, 0.5, 0.75].map((down) => [across, down]))) {
        await page.mouse.move(box.x + x * box.width, box.y + y * box.height);
        await page.waitForSelector('#loupe:visible');
        const words = await page.textContent('#loupe-words');
        const [, agreeing, all] =
            /^(\d+) of (\d+) pixels agree here\.$/.exec(words) ?? [0, 0, 0];
        assert.ok(all > 0 || /^No pixel/.test(words), words);
        assert.ok(Number(agreeing) <= Number(all), words);
        if (Number(agreeing) <= best) continue;
        best = Number(agreeing);
        if (process.env.TREELINE_SCREENSHOTS) {
          await page.screenshot({ path: path.join(
              process.env.TREELINE_SCREENSHOTS, 'loupe.png') });
        }
        // Both the picture's pixels and green marks on them.
        const { greens, colours } = await page.evaluate(() => {
          const canvas = document.querySelector('.loupe-picture');
          const { data } = canvas.getContext('2d')
              .getImageData(0, 0, canvas.width, canvas.height);
          const found = new Set();
          let count = 0;
          for (let i = 0; i < data.length; i += 4) {
            const [r, g, b] = data.subarray(i, i + 3);
            found.add(r << 16 | g << 8 | b);
            if (r === 0x7c && g === 0xf0 && b === 0xbd) count += 1;
          }
          return { greens: count, colours: found.size };
        });
        assert.ok(colours > 100, `${colours} colours`);
        assert.ok(greens > 20, `${greens} green pixels`);
        // Not over what it shows.
        const loupe = await page.locator('#loupe').boundingBox();
        const at = box.x + x * box.width;
        assert.ok(at < loupe.x || at > loupe.x + loupe.width);
      }
      assert.ok(best >= 2, `at most ${best} pixels agree`);
      await page.focus('#target');
      const told = new Set();
      for (let i = 0; i < 40; ++i) {
        await page.keyboard.press(i < 20 ? 'ArrowUp' : 'ArrowLeft');
        told.add(await page.textContent('#loupe-words'));
      }
      assert.ok(told.size > 1, [...told].join());
      await page.uncheck('#show-loupe');
      assert.equal(await page.locator('#loupe').isVisible(), false);
      assert.deepEqual(wrongs, []);
      await browser.close();
    });

test('a camera that was stopped is off, and starts again', async () => {
  const browser = await launchWithCamera(SEEN[0]);
  const { page, wrongs } = await open(browser, server.url);
  for (let i = 0; i < 3; ++i) {
    await page.click('#start');
    await waitForState(page, 'Located');
    await page.click('#start');
    await waitForState(page, 'Ready');
    assert.equal(
        await page.evaluate(() => document.querySelector('video').srcObject),
        null);
    assert.equal(await page.textContent('#confidence'), '–');
  }
  assert.deepEqual(wrongs, []);
  await browser.close();
});

test('everything is reached and done with the keyboard alone', async () => {
  const browser = await launchWithCamera(SEEN[0]);
  const { page } = await open(browser, server.url);
  const focused = () => page.evaluate(() => {
    const { id, tagName, parentElement } = document.activeElement;
    return id || `${tagName} ${parentElement.id}`;
  });
  const tabTo = async (id) => {
    for (let i = 0; i < 40; ++i) {
      if (await focused() === id) return;
      await page.keyboard.press('Tab');
    }
    assert.fail(`the keyboard does not reach ${id}`);
  };
  await tabTo('start');
  await page.keyboard.press('Enter');
  await waitForState(page, 'Located');
  await tabTo('target');
  for (const key of ['ArrowUp', 'ArrowLeft', 'Enter']) {
    await page.keyboard.press(key);
  }
  await page.waitForSelector('dialog[open]');
  assert.equal(await focused(), 'note-input');
  await page.keyboard.type('Typed');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#notes li');
  await tabTo('pin');
  await page.keyboard.press('Enter');
  await page.keyboard.press('Escape');
  assert.equal(await page.locator('#notes li').count(), 1);
  for (const folded of ['SUMMARY access', 'SUMMARY assumed']) {
    await tabTo(folded);
    await page.keyboard.press('Enter');
  }
  for (const id of ['scene', 'start', 'token', 'use-token', 'pin', 'show-grid',
    'show-box', 'show-points', 'show-loupe', 'show-still', 'view', 'corrects',
    'up']) {
    await tabTo(id);
  }
  await browser.close();
});

test('axe-core finds no fault, in either tone, dialogs included', async () => {
  const browser = await launchWithCamera(SEEN[0]);
  for (const colorScheme of ['light', 'dark']) {
    const { page, close } =
        await open(browser, server.url, { colorScheme });
    await assertAccessible(page, process.env.TREELINE_PAGE_WORK);
    for (const folded of ['access', 'assumed']) {
      await page.click(`#${folded} summary`);
    }
    await page.click('#start');
    await waitForState(page, 'Located');
    await page.check('#show-loupe');
    await page.click('#pin');
    await page.fill('#note-input', 'Here');
    await assertAccessible(page, process.env.TREELINE_PAGE_WORK);
    await page.click('#note-save');
    await page.waitForSelector('#notes li');
    await assertAccessible(page, process.env.TREELINE_PAGE_WORK);
    await close();
  }
  await browser.close();
});

test('what can be touched is large enough, on phones of either bearing',
    async () => {
      const browser = await launchWithCamera(SEEN[0]);
      for (const viewport of [{ width: 390, height: 844 },
        { width: 844, height: 390 }, { width: 1200, height: 760 }]) {
        const { page, close } = await open(browser, server.url, { viewport });
        await page.click('#access summary');
        await page.click('#assumed summary');
        const small = await page.evaluate(() => [...document.querySelectorAll(
            'button, select, summary, label.check, input:not([type=checkbox])')]
            .map((part) => ({ part, box: part.getBoundingClientRect() }))
            .filter(({ box }) => box.height > 0 &&
                (box.height < 44 || box.width < 44))
            .map(({ part, box }) =>
              `${part.id || part.textContent}: ${box.width}x${box.height}`));
        assert.deepEqual(small, []);
        assert.ok(await page.evaluate(() =>
          document.documentElement.scrollWidth <= window.innerWidth));
        await close();
      }
      await browser.close();
    });

test('without a camera the page says what to do', async () => {
  const browser = await launchWithCamera();
  const { page, wrongs } = await open(browser, server.url);
  await page.click('#start');
  await waitForState(page, 'No camera');
  assert.equal(await page.textContent('#start'), 'Start camera');
  assert.deepEqual(wrongs, []);
  await browser.close();
});

test('a picture of elsewhere is not located, in words', async () => {
  const browser = await launchWithCamera(SEEN[0]);
  const { page } = await open(browser, server.url);
  // Every picture becomes a wall without anything.
  await page.evaluate(() => {
    CanvasRenderingContext2D.prototype.drawImage = function drawGrey() {
      this.fillStyle = '#777';
      this.fillRect(0, 0, this.canvas.width, this.canvas.height);
    };
  });
  await page.click('#start');
  await waitForState(page, 'Not located');
  assert.match(await page.textContent('#state-text'), /Hold|Turn|Step|Move/);
  assert.equal(await page.evaluate(() => window.treeline.shareOf(2, 2, 1)),
      null);
  await browser.close();
});

test('a server with tokens is asked with the one that was entered',
    async (t) => {
      const folder = fs.mkdtempSync(path.join(tmpdir(), 'treeline-ar-keys-'));
      const key = path.join(folder, 'token.key');
      try {
        execFileSync('openssl', ['genrsa', '-out', key, '2048'],
            { stdio: 'pipe' });
      } catch (error) {
        if (error.code !== 'ENOENT') throw error;
        t.skip('no openssl on this machine');
        return;
      }
      fs.mkdirSync(path.join(folder, 'public'));
      execFileSync('openssl', ['rsa', '-in', key, '-pubout', '-out',
        path.join(folder, 'public', 'dev.pem')], { stdio: 'pipe' });
      const guarded =
          await startServer('--auth-keys', path.join(folder, 'public'));
      const token = execFileSync(path.join(process.env.TREELINE_ROOT, 'scripts',
          'make-dev-token'), [key, 'dev', 'phone', 'localize'],
      { encoding: 'utf8' }).trim();
      const browser = await launchWithCamera(SEEN[0]);
      const { page } = await open(browser, guarded.url);
      await waitForState(page, 'No access');
      await page.fill('#token', token);
      await page.click('#use-token');
      await waitForState(page, 'Ready');
      await page.click('#start');
      await waitForState(page, 'Located');
      // It does not outlast the window.
      assert.equal(await page.evaluate(() =>
        JSON.stringify(localStorage).includes(sessionStorage.getItem(
            'treeline.ar.token'))), false);
      await browser.close();
      guarded.kill();
    });
