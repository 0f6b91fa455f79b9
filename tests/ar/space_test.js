// The AR page's sessions in the space around a device that tracks itself
// (WebXR with camera access), with a device that plays recorded frames and
// their true poses. Environment as ar_page_test.js. With
// TREELINE_SCREENSHOTS=FOLDER it leaves pictures of itself there.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, before, test } from 'node:test';

import { installFakeSpace } from './fake_space.js';
import { FOCAL_PX, heldOut, HEIGHT_PX, launchWithCamera, RECORDING,
  startServer, trueCameraOf, trueShareOf, waitForState, WIDTH_PX } from
  './fixture.js';
import { assertAccessible } from '../page/accessibility.js';
import { wrongsOf } from '../page/browser.js';

// Of the recording: the device shows one frame after the other.
const RATE_HZ = 8;
const MEDIAN_PX = 3;
const NEAR_M = 0.01;
const NEAR_SHARE = 0.95;
const TRUE_VIEW_DEG = 2 * Math.atan(WIDTH_PX / 2 / FOCAL_PX) * 180 / Math.PI;

// The first frames that follow each other and were held out.
const WALK = heldOut.filter((time, i) => i === 0 ||
    heldOut.slice(0, i + 1).every((each, j, all) => j === 0 ||
        Number(each) - Number(all[j - 1]) < 1.5 / RATE_HZ));

// The device's space: y up, turned and elsewhere.
const DEVICE_YAW_RAD = 0.7;
const DEVICE_FROM_WORLD_M = [1.3, -0.4, 2.1];

const times = (a, b) => {
  const product = new Array(16).fill(0);
  for (let row = 0; row < 4; ++row) {
    for (let column = 0; column < 4; ++column) {
      for (let k = 0; k < 4; ++k) {
        product[4 * column + row] += a[4 * k + row] * b[4 * column + k];
      }
    }
  }
  return product;
};

// By columns. World x, y, z become x, z, -y, turned about what is up.
function deviceFromWorld() {
  const [c, s] = [Math.cos(DEVICE_YAW_RAD), Math.sin(DEVICE_YAW_RAD)];
  const zUpToYUp = [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1];
  const yaw = [c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0,
    ...DEVICE_FROM_WORLD_M, 1];
  return times(yaw, zUpToYUp);
}

function worldFromView(time) {
  const { position: p, rotation: { w, x, y, z } } = trueCameraOf(time);
  const worldFromCamera = [
    1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0,
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0,
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0,
    p.x, p.y, p.z, 1];
  // WebXR's view has y up and looks along -z.
  return times(worldFromCamera,
      [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1]);
}

const DEVICE = {
  rateHz: RATE_HZ,
  // Depths are of no matter here: near 0.1 m, far 1000 m.
  projection: [2 * FOCAL_PX / WIDTH_PX, 0, 0, 0, 0, 2 * FOCAL_PX / HEIGHT_PX,
    0, 0, 0, 0, -1.0002, -1, 0, 0, -0.20002, 0],
  frames: WALK.map((time) => ({
    matrix: times(deviceFromWorld(), worldFromView(time)),
    jpeg: fs.readFileSync(path.join(RECORDING, 'rgb', `${time}.jpg`))
        .toString('base64'),
  })),
};

let server;
let browser;
before(async () => {
  server = await startServer();
  browser = await launchWithCamera();
});
after(async () => {
  await browser?.close();
  server?.kill();
});

async function openWith(device, options = {}) {
  const context = await browser.newContext({
    // The shape of the pictures.
    viewport: { width: 960, height: 720 }, reducedMotion: 'reduce',
    ...options });
  context.setDefaultTimeout(60000);
  const page = await context.newPage();
  if (device !== null) await page.addInitScript(installFakeSpace, device);
  const wrongs = wrongsOf(page, server.url);
  await page.goto(server.url);
  await waitForState(page, 'Ready');
  return { page, wrongs, close: () => context.close() };
}

const middleOf = (values) =>
  values.sort((a, b) => a - b)[Math.floor(values.length / 2)];

// What is drawn in each of so many further frames, with the frame's time.
async function drawnIn(page, count, points) {
  const drawn = [];
  for (let i = 0; i < count; ++i) {
    const views = await page.evaluate(() => window.fakeSpace.views);
    await page.waitForFunction((last) => window.fakeSpace.views > last, views);
    const { shown, shares } = await page.evaluate((at) => ({
      shown: window.fakeSpace.shown,
      shares: at.map((point) => window.treeline.shareOf(...point)),
    }), points);
    drawn.push({ time: WALK[shown], shares });
  }
  return drawn;
}

const isSeen = (share) => share !== null &&
    Math.min(share.x, share.y) >= 0 && Math.max(share.x, share.y) <= 1;

function errorPx(drawn, truth) {
  return drawn === null ? Infinity : Math.hypot(
      (drawn.x - truth.x) * WIDTH_PX, (drawn.y - truth.y) * HEIGHT_PX);
}

async function screenshot(page, name) {
  const folder = process.env.TREELINE_SCREENSHOTS;
  if (!folder) return;
  // A compositor would show the camera behind the page.
  await page.evaluate(async (jpegs) => {
    const behind = new Image();
    behind.src = URL.createObjectURL(new Blob([Uint8Array.from(
        atob(jpegs[window.fakeSpace.shown]), (c) => c.charCodeAt(0))]));
    await behind.decode();
    behind.style.cssText =
        'position:fixed;inset:0;width:100%;height:100%;z-index:-1';
    behind.id = 'behind';
    document.body.append(behind);
  }, DEVICE.frames.map(({ jpeg }) => jpeg));
  await page.screenshot({ path: path.join(folder, `${name}.png`) });
  await page.evaluate(() => document.querySelector('#behind').remove());
}

test('the drawing follows the device, and answers tell where it is',
    async () => {
      assert.ok(WALK.length >= 4, `${WALK.length} frames`);
      const { page, wrongs, close } = await openWith(DEVICE);
      await page.click('#start-space');
      await waitForState(page, 'Located');
      const { asked } = await page.evaluate(() => window.fakeSpace);
      assert.equal(asked.mode, 'immersive-ar');
      assert.ok(asked.features.includes('camera-access'));
      // The device's own camera is stated, not a guess.
      await page.waitForFunction(() =>
        document.querySelector('#focal').textContent.includes('as stated'));
      const view = Number.parseFloat(await page.textContent('#focal'));
      assert.ok(Math.abs(view - TRUE_VIEW_DEG) < 0.1, `${view} degrees`);
      const points = [];
      for (let x = 0.5; x < 5; x += 0.75) {
        for (let y = 0.5; y < 4.3; y += 0.75) {
          for (let z = 0.3; z < 2.6; z += 0.6) points.push([x, y, z]);
        }
      }
      const errors = [];
      for (const { time, shares } of await drawnIn(page, 20, points)) {
        for (const [i, point] of points.entries()) {
          const truth = trueShareOf(time, point);
          if (isSeen(truth)) errors.push(errorPx(shares[i], truth));
        }
      }
      const middle = middleOf(errors);
      console.log(`median ${middle.toFixed(2)} px of ${errors.length} points`);
      assert.ok(errors.length > 200, `${errors.length} points`);
      assert.ok(middle <= MEDIAN_PX, `median of ${middle} px`);

      // It is seen, and goes with its layers.
      const seen = async () => {
        const shot = await page.locator('canvas.overlay').screenshot();
        return shot.length;
      };
      const all = await seen();
      await page.evaluate(() => {
        for (const layer of ['grid', 'box']) {
          document.querySelector(`#show-${layer}`).click();
        }
      });
      await drawnIn(page, 2, []);
      assert.ok(await seen() < all, 'nothing was drawn');
      assert.deepEqual(wrongs, []);
      await close();
    });

test('a note stays at its place while the device moves', async () => {
  const { page, wrongs, close } = await openWith(DEVICE,
      { viewport: { width: 480, height: 360 } });
  await page.click('#start-space');
  await waitForState(page, 'Located');
  // Where the last answer has no point near, the page says so and asks for
  // another try.
  for (let i = 0; i < 60 && !await page.isVisible('dialog[open]'); ++i) {
    await page.click('#target', { position: { x: 240, y: 120 } });
    await page.waitForTimeout(100);
  }
  await page.fill('#note-input', 'Here');
  await page.click('#note-save');
  const [note] = await page.evaluate(() =>
    JSON.parse(localStorage.getItem('treeline.ar.notes.room')));
  const { x, y, z } = note.pointInWorldM;
  assert.ok(x > -0.5 && x < 6 && y > -0.5 && y < 5.5 && z > -0.5 && z < 3.5,
      `${x}, ${y}, ${z}`);
  await screenshot(page, 'space-note');
  const errorsM = (await drawnIn(page, 40, [[x, y, z]]))
      .map(({ time, shares: [share] }) => ({
        share, truth: trueShareOf(time, [x, y, z]),
        distanceM: Math.hypot(...['x', 'y', 'z'].map((axis, i) =>
          [x, y, z][i] - trueCameraOf(time).position[axis])) }))
      .filter(({ truth }) => isSeen(truth))
      .map(({ share, truth, distanceM }) =>
        distanceM / FOCAL_PX * errorPx(share, truth));
  const within = errorsM.filter((error) => error <= NEAR_M).length;
  console.log(`note: ${within} of ${errorsM.length} within 1 cm, median ` +
      `${(100 * middleOf(errorsM)).toFixed(2)} cm`);
  assert.ok(errorsM.length >= 15, `${errorsM.length} times in view`);
  assert.ok(within >= NEAR_SHARE * errorsM.length);
  assert.deepEqual(wrongs, []);
  await close();
});

test('a session ends by the page, by the device, and begins again',
    async () => {
      const { page, wrongs, close } = await openWith(DEVICE);
      for (const byPage of [true, false, true]) {
        await page.click('#start-space');
        await waitForState(page, 'Located');
        assert.ok(await page.locator('#start').isVisible());
        await (byPage ? page.click('#start') : page.evaluate(() =>
          window.fakeSpace.sessions.at(-1).end()));
        await waitForState(page, 'Ready');
        assert.ok(await page.evaluate(() =>
          window.fakeSpace.sessions.at(-1).ended));
        assert.ok(await page.locator('#scene').isVisible());
      }
      assert.deepEqual(wrongs, []);
      await close();
    });

test('what fits no phone has larger targets than fingers, in space too',
    async () => {
      for (const viewport of [{ width: 390, height: 844 },
        { width: 844, height: 390 }, { width: 820, height: 1180 }]) {
        const { page, close } = await openWith(DEVICE, { viewport });
        await page.click('#start-space');
        await waitForState(page, 'Located');
        await screenshot(page, `space-${viewport.width}`);
        await assertAccessible(page, process.env.TREELINE_PAGE_WORK);
        for (const id of ['start', 'pin']) {
          const box = await page.locator(`#${id}`).boundingBox();
          assert.ok(box.width >= 44 && box.height >= 44 && box.y > 0 &&
              box.y + box.height <= viewport.height, JSON.stringify(box));
        }
        // Most of the space is to be seen.
        const side = await page.locator('.side').boundingBox();
        assert.ok(side.height < 0.5 * viewport.height, JSON.stringify(side));
        await close();
      }
    });

test('a device that refuses is told in words; one without offers nothing',
    async () => {
      for (const [refusal, words] of [
        ['NotSupportedError', /no camera in augmented reality/],
        ['NotAllowedError', /Allow it for this page/]]) {
        const { page, wrongs, close } = await openWith({ ...DEVICE, refusal });
        await page.click('#start-space');
        await waitForState(page, 'Not in space');
        assert.match(await page.textContent('#state-text'), words);
        assert.ok(await page.locator('#start:enabled').isVisible());
        assert.deepEqual(wrongs, []);
        await close();
      }
      const { page, close } = await openWith(null);
      assert.equal(await page.locator('#start-space').isVisible(), false);
      await close();
    });
