// The AR page, the scene page and the page of `treeline learn` on phones and a
// tablet: everything is seen, touched, and reached with a keyboard or a screen
// reader, in either tone. Environment as ar_page_test.js, and
// TREELINE_LEARN_PAGE. With TREELINE_SCREENSHOTS=FOLDER it leaves pictures
// there.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';

import { heldOut, launchWithCamera, localizePicture, open, RECORDING,
  startServer, telling, truePointAt, waitForState } from './fixture.js';
import { assertAccessible } from '../page/accessibility.js';
import { layoutFaults, nameFaults, walkByKeyboard } from '../page/layout.js';

const { TREELINE_LEARN_PAGE, TREELINE_PAGE_WORK, TREELINE_SCREENSHOTS } =
    process.env;

const PHONE = { hasTouch: true, isMobile: true, deviceScaleFactor: 2 };
const DEVICES = [
  { name: 'portrait', ...PHONE, viewport: { width: 360, height: 640 } },
  { name: 'landscape', ...PHONE, viewport: { width: 740, height: 360 } },
  { name: 'tablet', ...PHONE, deviceScaleFactor: 1,
    viewport: { width: 820, height: 1180 } },
];
const TONES = ['light', 'dark'];

let server;
let browser;
before(async () => {
  server = await startServer('--recent-queries', '5');
  browser = await launchWithCamera(SEEN);
  for (const time of heldOut.slice(0, 3)) {
    await localizePicture(server,
        fs.readFileSync(path.join(RECORDING, 'rgb', `${time}.jpg`)));
  }
});
after(async () => {
  await browser?.close();
  server?.kill();
});

// A page whose camera goes on asks the server on.
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});

const opened = (url, options, script = '') =>
  open(browser, url, options, null, script);

const onEach = (what, work) => {
  for (const { name, ...device } of DEVICES) {
    for (const colorScheme of TONES) {
      test(`${what}, ${name}, ${colorScheme}`, () =>
        work({ ...device, colorScheme }, `${name}-${colorScheme}`));
    }
  }
};

async function shoot(page, name) {
  if (!TREELINE_SCREENSHOTS) return;
  await page.screenshot(
      { path: path.join(TREELINE_SCREENSHOTS, `${name}.png`) });
}

// All that is there, with what was folded unfolded.
async function assertUsable(page, name, options) {
  await shoot(page, name);
  assert.deepEqual(await layoutFaults(page, options), []);
  assert.deepEqual(await nameFaults(page), []);
  await assertAccessible(page, TREELINE_PAGE_WORK);
  const { names, faults } = await walkByKeyboard(page);
  assert.deepEqual(faults, []);
  await shoot(page, `${name}-below`);
  return names;
}

async function unfold(page) {
  for (const folded of await page.locator('summary').all()) {
    await folded.click();
  }
  await page.locator('.side').evaluate((side) => side.scrollTo(0, 0));
}

// Notes near the edges of the picture, where their labels have least room.
const SEEN = telling[0];
const NOTES = [[0.06, 0.5], [0.94, 0.75], [0.5, 0.06]].map(([x, y], i) => {
  const [px, py, pz] = truePointAt(SEEN, { x, y }, 2);
  return { id: `note${i}`, text: `Note ${i + 1}, of some length`,
    pointInWorldM: { x: px, y: py, z: pz } };
});
const KEEP_NOTES = `localStorage.setItem('treeline.ar.notes.room', ${
  JSON.stringify(JSON.stringify(NOTES))})`;

// These tests can fail.
test('what is cut off, covered, small, nameless or unreached is found',
    async () => {
      const context = await browser.newContext(DEVICES[0]);
      const page = await context.newPage();
      const faultsOf = async (html) => {
        await page.setContent(`<!doctype html><meta name=viewport content="width=device-width">
          <style>* { margin: 0; box-sizing: border-box; } button { width: 44px;
          height: 44px; } :focus { outline: 2px solid red }</style>${html}`);
        return [...await layoutFaults(page), ...await nameFaults(page),
          ...(await walkByKeyboard(page)).faults].join('; ');
      };
      assert.equal(await faultsOf('<button>Go</button><p>Words</p>'), '');
      for (const [html, fault] of [
        ['<p style="width: 500px">Words</p>', /the page scrolls to the side/],
        ['<p style="margin-left: -20px">Words</p>', /is beside the page/],
        ['<p style="width: 3em; overflow: hidden; white-space: nowrap">' +
          'Many words</p>', /'Many words' is cut off at the side/],
        ['<p style="height: 0.5em; overflow: hidden">Words</p>',
          /'Words' is cut off by/],
        ['<p>Words</p><p style="margin-top: -10px">Others</p>',
          /'Words' and 'Others' lie over each other/],
        ['<button style="height: 30px">Go</button>', /is 44 x 30 px to touch/],
        ['<button>Go</button><div style="position: fixed; inset: 0">',
          /'Go' is covered by div/],
        ['<button></button>', /a button has no name/],
        ['<button tabindex="-1">Go</button>', /Go: Tab does not come to it/],
        ['<button style="outline: none">Go</button>',
          /Go: the focus is not visible/],
        ['<button tabindex="2">B</button><button tabindex="1">A</button>',
          /Tab does not come to it/],
      ]) {
        assert.match(await faultsOf(html), fault, html);
      }
    });

onEach('the AR page is seen, touched and reached', async (options, name) => {
  const { page, wrongs } =
      await opened(server.url, options, KEEP_NOTES);
  const first = await assertUsable(page, `ar-${name}-ready`);
  assert.deepEqual(first.slice(0, 3), ['scene-link', 'scene', 'start']);
  await page.click('#start');
  await waitForState(page, 'Located');
  await page.waitForFunction((count) => [...document.querySelectorAll(
      'button.label')].filter((label) => label.checkVisibility()).length ===
        count, NOTES.length);
  await unfold(page);
  const names = await assertUsable(page, `ar-${name}-located`);
  const order = ['scene-link', 'target', 'scene', 'start', 'token',
    'edit-note0', 'pin', 'show-grid', 'view', 'up'];
  assert.deepEqual(names.filter((each) => order.includes(each)), order);
  assert.deepEqual(wrongs, []);
});

onEach('the scene page is seen, touched and reached', async (options, name) => {
  const { page, wrongs } =
      await opened(`${server.url}scene.html?scene=room`, options);
  await waitForState(page, 'Shown');
  await page.waitForSelector('#queries li');
  await unfold(page);
  const names = await assertUsable(page, `scene-${name}`);
  const order = ['view3d', 'scene', 'token', 'look-overview', 'nearer',
    'show-points', 'show-queries'];
  assert.deepEqual(names.filter((each) => order.includes(each)), order);
  assert.deepEqual(wrongs, []);
});

onEach('the page of treeline learn is seen and reached',
    async (options, name) => {
      const context = await browser.newContext({ ...options, bypassCSP: true });
      const page = await context.newPage();
      await page.goto(pathToFileURL(TREELINE_LEARN_PAGE).href);
      await assertUsable(page, `learn-${name}`, { mayScroll: '.scroll' });
      // Whatever the verdict is.
      for (const grade of ['good', 'fair', 'poor']) {
        await page.locator('.headline').evaluate((line, to) => {
          line.className = `headline ${to}`;
        }, grade);
        await assertAccessible(page, TREELINE_PAGE_WORK);
      }
    });

test('the keyboard stays in a dialog, and comes back to where it was',
    async () => {
      const { page } = await opened(server.url, DEVICES[0]);
      await page.click('#start');
      await waitForState(page, 'Located');
      const focused = () => page.evaluate(() => ({
        id: document.activeElement.id,
        label: document.activeElement.ariaLabel,
        isInDialog: document.activeElement.closest('dialog') !== null,
        isNowhere: document.activeElement === document.body }));
      await page.focus('#target');
      await page.keyboard.press('Enter');
      await page.waitForSelector('dialog[open]');
      assert.equal((await focused()).id, 'note-input');
      for (const key of ['Tab', 'Shift+Tab']) {
        for (let i = 0; i < 8; ++i) {
          await page.keyboard.press(key);
          const { isInDialog, isNowhere } = await focused();
          // Nowhere of the page: the browser's own bar has it.
          assert.ok(isInDialog || isNowhere, `${key} leaves the dialog`);
        }
      }
      await page.keyboard.press('Escape');
      assert.equal(await page.locator('dialog[open]').count(), 0);
      assert.equal((await focused()).id, 'target');

      await page.keyboard.press('Enter');
      await page.keyboard.type('First');
      await page.keyboard.press('Enter');
      await page.waitForSelector('#notes li');
      assert.equal((await focused()).id, 'target');
      await page.locator('#notes button').focus();
      await page.keyboard.press('Enter');
      await page.keyboard.type(' again');
      await page.keyboard.press('Enter');
      await page.waitForFunction(() =>
        document.querySelector('.note-text').textContent === 'First again');
      assert.equal((await focused()).label, 'Edit the note: First again');
      await page.keyboard.press('Enter');
      await page.click('#note-delete');
      await page.waitForSelector('#notes li', { state: 'detached' });
      assert.equal((await focused()).id, 'pin');
      // Enter saves, and does not press the button that it comes back to.
      await page.keyboard.press('Enter');
      await page.keyboard.type('Second');
      await page.keyboard.press('Enter');
      await page.waitForSelector('#notes li');
      assert.equal((await focused()).id, 'pin');
      assert.equal(await page.locator('dialog[open]').count(), 0);
    });

test('a screen reader is told whether the camera is located', async () => {
  const { page } = await opened(server.url, DEVICES[0]);
  // What the region says, each time that it says something else.
  await page.evaluate(() => {
    const region = document.querySelector('#state').closest('[role=status]');
    window.said = [];
    new MutationObserver(() => {
      if (region.isConnected && region.textContent !== window.said.at(-1)) {
        window.said.push(region.textContent);
      }
    }).observe(region, { childList: true, characterData: true, subtree: true });
  });
  await page.click('#start');
  await waitForState(page, 'Located');
  const answers = await page.evaluate(() => window.treeline.answers());
  await page.waitForFunction(
      (before) => window.treeline.answers() >= before + 2, answers);
  // Now every picture is a wall without anything.
  await page.evaluate(() => {
    CanvasRenderingContext2D.prototype.drawImage = function drawGrey() {
      this.fillStyle = '#777';
      this.fillRect(0, 0, this.canvas.width, this.canvas.height);
    };
  });
  await waitForState(page, 'Not located');
  const said = await page.evaluate(() => window.said);
  assert.match(said.at(0), /^Looking/);
  assert.ok(said.some((words) => /^Located/.test(words)), said.join('\n'));
  assert.match(said.at(-1), /^Not located.*(Hold|Turn|Step|Move)/);
  // Once each: who listens is not told the same with every answer.
  assert.equal(said.filter((words) => /^Located/.test(words)).length, 1);
});
