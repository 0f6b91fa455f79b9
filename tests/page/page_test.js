// The operator's page in a real browser, against an agent that the test plays.
// TREELINE_PAGE: the built page; TREELINE_PAGE_WORK: where its packages are;
// TREELINE_PICTURE: any JPEG picture.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import { after, before, beforeEach, afterEach, test } from 'node:test';

import { assertAccessible } from './accessibility.js';
import { dragOnMap, launch, openPage, windowOf } from './browser.js';
import { near, text } from './checks.js';
import { MockAgent } from './mock_agent.js';

let browser;
let agent;
let url;

const newAgent = (options = {}) => new MockAgent({
  pageFolder: process.env.TREELINE_PAGE,
  picture: fs.readFileSync(process.env.TREELINE_PICTURE), ...options,
});

before(async () => {
  browser = await launch(process.env.TREELINE_PAGE_WORK);
});
after(() => browser?.close());
beforeEach(async () => {
  agent = newAgent();
  url = await agent.listen();
});
afterEach(() => agent.vanish());

// Waits for the agent, not for a time.
async function asked(method) {
  for (let i = 0; i < 1500; ++i) {
    const body = agent.lastAsked(method);
    if (body !== undefined) return body;
    await new Promise((resolve) => { setTimeout(resolve, 20); });
  }
  assert.fail(`${method} was not asked; only ` +
      JSON.stringify(agent.asked.map((entry) => entry.method)));
  return undefined;
}

test('a goal is sent by a drag and followed to its end', async () => {
  const { page, wrongs, close } = await openPage(browser, url);
  await text(page, '#mode', 'Ready');
  await page.click('#tool-goal');
  await dragOnMap(page, [3.5, 4.9, 0], [3.5, 6.4, 0]);
  const { poses } = await asked('Navigate');
  assert.equal(poses.length, 1);
  near(poses[0].xM, 3.5);
  near(poses[0].yM, 4.9);
  near(poses[0].yawRad, Math.PI / 2, 0.1);
  assert.equal(poses[0].level, 0);
  await text(page, '#mode', 'Driving');
  await text(page, '#goal', 'to go');
  await text(page, '#events', 'accepted');
  await text(page, '#goal', 'Arrived');
  assert.equal(await page.getAttribute('#tool-look', 'aria-pressed'), 'true');
  assert.deepEqual(wrongs, []);
  await close();
});

test('a click on the terrace hits its ground, not what is behind', async () => {
  const { page, close } = await openPage(browser, url);
  await page.click('#tool-goal');
  await dragOnMap(page, [11.2, 6.2, 0.5]);
  const { poses } = await asked('Navigate');
  near(poses[0].xM, 11.2);
  near(poses[0].yM, 6.2);
  // A click alone: on from the robot.
  near(poses[0].yawRad, Math.atan2(6.2 - 4.9, 11.2 - 2), 0.05);
  await close();
});

test('the robot is told where it is', async () => {
  const { page, close } = await openPage(browser, url);
  await page.click('#tool-pose');
  await dragOnMap(page, [6.2, 6.2, 0], [4.9, 6.2, 0]);
  const { mapFromBase: pose } = await asked('SetInitialPose');
  near(pose.xM, 6.2);
  near(pose.yM, 6.2);
  near(Math.abs(pose.yawRad), Math.PI, 0.1);
  await close();
});

test('buttons ask for what they say', async () => {
  const { page, wrongs, close } = await openPage(browser, url);
  // Of a robot that does not tell of its battery nothing is said.
  assert.equal(await page.isVisible('#battery'), false);
  agent.battery = { voltageV: 74.5, charge: 0.76 };
  await text(page, '#battery', '76 % · 74.5 V');
  assert.equal(await page.isDisabled('#cancel'), true);
  agent.obey('Navigate', { poses: [{ xM: 12, yM: 1, yawRad: 0, level: 0 }] });
  await page.click('#pause');
  await asked('Pause');
  await text(page, '#pause', 'Resume');
  await page.click('#pause');
  await asked('Resume');
  await page.click('#find-yourself');
  await asked('FindYourself');
  await page.click('#cancel:enabled');
  assert.equal((await asked('Cancel')).goalId, 0n);
  await text(page, '#goal', 'Cancelled');
  assert.deepEqual(wrongs, []);
  await close();
});

// Of the method, so many at least.
async function askedTimes(method, times) {
  for (let i = 0; i < 1500; ++i) {
    const all = agent.asked.filter((entry) => entry.method === method);
    if (all.length >= times) return all.map(({ body }) => body);
    await new Promise((resolve) => { setTimeout(resolve, 20); });
  }
  assert.fail(`${method} was not asked ${times} times`);
  return undefined;
}

test('a stop holds on the page until it is released', async () => {
  const { page, wrongs, close } = await openPage(browser, url);
  assert.equal(await page.isVisible('#stopped'), false);
  await page.click('#stop');
  assert.match((await asked('Stop')).why, /page/);
  await text(page, '#mode', 'Stopped');
  await text(page, '#stopped', 'Stopped until it is released');
  await page.click('#release');
  await asked('Release');
  await page.waitForSelector('#stopped', { state: 'hidden' });
  await text(page, '#mode', 'Ready');
  await page.keyboard.press('x');
  assert.equal((await askedTimes('Stop', 2)).length, 2);
  assert.deepEqual(wrongs, []);
  await close();
});

test('a stop that a restart would forget says so', async () => {
  agent.stopWarning = 'a restart forgets the stop';
  const { page, close } = await openPage(browser, url);
  await page.click('#stop');
  await text(page, '#toasts', 'Stopped. a restart forgets the stop');
  await close();
});

for (const [what, options] of [
  ['1280 x 800', { viewport: { width: 1280, height: 800 } }],
  ['a phone', { viewport: { width: 360, height: 740 }, isMobile: true,
    hasTouch: true }],
  ['a phone on its side', { viewport: { width: 740, height: 360 },
    isMobile: true, hasTouch: true }],
  ['a small window', { viewport: { width: 900, height: 500 } }],
]) {
  test(`the stop is in reach at ${what}, scrolled or not`, async () => {
    const { page, close } = await openPage(browser, url, options);
    const inReach = () => page.$eval('#stop', (stop) => {
      const { x, y, width, height } = stop.getBoundingClientRect();
      const at = document.elementFromPoint(x + width / 2, y + height / 2);
      return at === stop && x >= 0 && y >= 0 && x + width <= innerWidth &&
        y + height <= innerHeight && height >= 36;
    });
    assert.equal(await inReach(), true);
    await page.$eval('#events', (events) => events.scrollIntoView());
    assert.equal(await inReach(), true);
    await agent.vanish();
    await text(page, '#link', 'No connection');
    assert.equal(await inReach(), true);
    await close();
  });
}

test('camera, devices and events are in sight at 1280 x 800', async () => {
  const { page, close } = await openPage(
      browser, url, { viewport: { width: 1280, height: 800 } });
  await text(page, '#devices', 'Server');
  for (const what of ['#stop', '#mode', '#drive-pad', '#camera .camera-frame',
    '#devices li:last-child', '#events .events']) {
    const box = await page.locator(what).boundingBox();
    assert.ok(box.y >= 0 && box.y + box.height <= 800 && box.height > 10,
        `${what}: ${JSON.stringify(box)}`);
  }
  // What breaks a simulated robot is not beside what drives it.
  assert.equal(await page.isVisible('#kidnap-anywhere'), false);
  assert.equal(await page.isVisible('#tool-kidnap'), false);
  await close();
});

test('the pad drives while it is held, and its release is a stop', async () => {
  const { page, wrongs, close } = await openPage(browser, url);
  await page.locator('#drive-pad').scrollIntoViewIfNeeded();
  const box = await page.locator('#drive-pad').boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x, box.y + 4);
  const held = await askedTimes('Drive', 4);
  assert.ok(held.at(-1).forwardMps > 0.3, JSON.stringify(held.at(-1).forwardMps));
  assert.notEqual(held[0].driver, '');
  await page.mouse.up();
  await page.waitForSelector('#drive-pad[data-driven=false]');
  const all = agent.asked.filter(({ method }) => method === 'Drive')
      .map(({ body }) => body);
  const last = all.reduce((a, b) => (a.sequence > b.sequence ? a : b));
  assert.equal(last.forwardMps, 0);
  assert.equal(new Set(all.map(({ sequence }) => sequence)).size, all.length);
  assert.deepEqual(wrongs, []);
  await close();
});

test('arrow keys drive; a page that loses the focus lets go', async () => {
  const { page, close } = await openPage(browser, url);
  await page.focus('#drive-pad');
  await page.keyboard.down('ArrowUp');
  await askedTimes('Drive', 3);
  await page.evaluate(() => window.dispatchEvent(new Event('blur')));
  await page.waitForSelector('#drive-pad[data-driven=false]');
  const newest = () => agent.asked.filter(({ method }) => method === 'Drive')
      .map(({ body }) => body)
      .reduce((a, b) => (a.sequence > b.sequence ? a : b));
  for (let i = 0; i < 1500 && newest().forwardMps !== 0; ++i) {
    await page.waitForTimeout(20);
  }
  assert.equal(newest().forwardMps, 0);
  await page.keyboard.up('ArrowUp');
  await page.focus('#drive-pad');
  await page.keyboard.down('ArrowLeft');
  await page.waitForSelector('#drive-pad[data-driven=true]');
  await page.focus('#pause');
  await page.waitForSelector('#drive-pad[data-driven=false]');
  await close();
});

test('a refusal to be driven is said once', async () => {
  agent.refusals.set('Drive', 'The robot is stopped.');
  const { page, close } = await openPage(browser, url);
  await page.focus('#drive-pad');
  await page.keyboard.down('ArrowUp');
  await text(page, '#toasts', 'The robot is stopped.');
  assert.equal(await page.locator('.toast').count(), 1);
  assert.equal(
      await page.getAttribute('#drive-pad', 'data-driven'), 'false');
  await close();
});

test('in simulation the robot is kidnapped and hindered', async () => {
  const { page, wrongs, close } = await openPage(browser, url);
  await page.click('#simulation summary');
  await page.click('#kidnap-anywhere');
  assert.equal((await asked('Kidnap')).to.case, undefined);
  await page.selectOption('#place', 'kitchen');
  await page.click('#kidnap-place');
  await page.click('#tool-kidnap');
  await dragOnMap(page, [10.4, 4.2, 0]);
  for (let i = 0; i < 1500 && agent.asked.length < 3; ++i) {
    await page.waitForTimeout(20);
  }
  const kidnaps = agent.asked.map(({ body }) => body.to.value);
  assert.equal(kidnaps[1], 'kitchen');
  near(kidnaps[2].xM, 10.4);
  near(kidnaps[2].yM, 4.2);
  await page.click('#tool-obstacle');
  await dragOnMap(page, [3, 3.4, 0]);
  const box = await asked('AddObstacle');
  near(box.xM, 3);
  near(box.yM, 3.4);
  assert.equal(box.sizeM, 0.5);
  await page.click('text=Remove');
  assert.equal((await asked('RemoveObstacle')).name, 'box-1');
  await page.selectOption('#fault', { label: 'Laser silent' });
  await page.click('#fault-start');
  const { target, kind, durationS } = await asked('InjectFault');
  assert.deepEqual([target, kind, durationS], ['laser', 'silent', 5]);
  assert.deepEqual(wrongs, []);
  await close();
});

test('a real robot cannot be kidnapped from the page', async () => {
  await agent.vanish();
  agent = newAgent({ simulated: false });
  url = await agent.listen();
  const { page, close } = await openPage(browser, url);
  for (const what of ['#simulation', '#tool-kidnap', '#tool-obstacle', '#world',
    '[data-layer=truth]']) {
    assert.equal(await page.isVisible(what), false, what);
  }
  assert.equal(await page.isVisible('#tool-goal'), true);
  await close();
});

test('what the agent refuses is said in its words', async () => {
  agent.refusals.set('Navigate', 'The goal is not on the map.');
  const { page, close } = await openPage(browser, url);
  await page.click('#tool-goal');
  await dragOnMap(page, [3, 4, 0]);
  await text(page, '#toasts', 'The goal is not on the map.');
  await close();
});

test('a robot that is lost is nowhere said to be on its way', async () => {
  agent.lost = { probability: 0.69, state: 'localized', reason: 'none' };
  const { page, wrongs, close } = await openPage(browser, url);
  agent.obey('Navigate', { poses: [{ xM: 12, yM: 1, yawRad: 0, level: 0 }] });
  await text(page, '#lost', '69 %');
  await text(page, '#lost', 'Is not sure of its place');
  await text(page, '#goal', 'On the way');
  agent.mode = 'relocalizing';
  await text(page, '#mode', 'Finding its place');
  await text(page, '#lost', 'Looks for its place');
  await text(page, '#goal', 'Waits until the robot knows its place.');
  const side = await page.textContent('.side');
  assert.doesNotMatch(side, /[Oo]n the way|Localized|m to go/);
  assert.deepEqual(wrongs, []);
  await close();
});

test('a stop is explained with what to do about it', async () => {
  agent.mode = 'safe_stop';
  agent.cause = 'laser_lost';
  agent.advice = 'Look at the laser\'s cable, power and address.';
  agent.devices[0] = { name: 'laser', state: 'lost', cause: 'no scan' };
  agent.lost = { probability: 0.85, state: 'lost', reason: 'scans do not fit' };
  const { page, close } = await openPage(browser, url);
  await text(page, '#mode', 'Safe stop');
  await text(page, '#cause', 'Laser lost.');
  await text(page, '#advice', 'cable');
  await text(page, '#devices', 'lost: no scan');
  await text(page, '#lost', '85 %');
  await close();
});

test('markup that comes from the agent stays text', async () => {
  agent.causeText = '<img src=x onerror=alert(1)>';
  agent.say('<b>', '<script>alert(1)</script>');
  const { page, wrongs, close } = await openPage(browser, url);
  await text(page, '#events', '<script>alert(1)</script>');
  await text(page, '#cause', 'onerror=alert(1)');
  assert.equal(await page.locator('#events script, #cause img').count(), 0);
  assert.deepEqual(wrongs, []);
  await close();
});

for (const [what, go] of [
  ['vanishes', () => agent.vanish()], ['falls silent', () => agent.fallSilent()],
]) {
  test(`an agent that ${what} is noticed, and found again`, async () => {
    const { page, wrongs, close } = await openPage(
        browser, url, {}, /ERR_|Failed to load/);
    await text(page, '#link', 'Live');
    await go();
    await text(page, '#link', 'No connection');
    assert.equal(await page.isVisible('#banner'), true);
    assert.match(await page.getAttribute('body', 'class'), /is-stale/);
    assert.equal(
        await page.$eval('.buttons', (buttons) => buttons.inert), true);
    if (what !== 'vanishes') await agent.vanish();
    const port = agent.port;
    agent = newAgent();
    agent.mode = 'paused';
    await agent.listen(port);
    await text(page, '#link', 'Live');
    await text(page, '#mode', 'Paused');
    assert.equal(await page.isVisible('#banner'), false);
    assert.equal(
        await page.$eval('.buttons', (buttons) => buttons.inert), false);
    assert.deepEqual(wrongs, []);
    await close();
  });
}

test('layers are hidden, and stay so', async () => {
  const { page, close } = await openPage(browser, url);
  await page.click('.layers summary');
  assert.equal(await page.isChecked('[data-layer=tree] input'), false);
  await page.uncheck('[data-layer=octomap] input');
  await page.reload();
  await page.waitForSelector('#map[data-map=ready]');
  await page.click('.layers summary');
  assert.equal(await page.isChecked('[data-layer=octomap] input'), false);
  assert.equal(await page.isChecked('[data-layer=path] input'), true);
  await close();
});

test('a phone shows everything without scrolling sideways', async () => {
  const { page, wrongs, close } = await openPage(browser, url, {
    viewport: { width: 360, height: 740 }, isMobile: true, hasTouch: true });
  const [page_width, window_width] = await page.evaluate(
      () => [document.documentElement.scrollWidth, window.innerWidth]);
  assert.equal(page_width, window_width);
  for (const control of await page.$$('button:visible')) {
    const box = await control.boundingBox();
    assert.ok(box.x >= 0 && box.x + box.width <= 360.5 && box.height >= 28,
        `${await control.textContent()}: ${JSON.stringify(box)}`);
  }
  await page.tap('#tool-goal');
  const at = await windowOf(page, 6, 6, 0);
  await page.touchscreen.tap(at.x, at.y);
  const { poses } = await asked('Navigate');
  near(poses[0].xM, 6, 0.2);
  near(poses[0].yM, 6, 0.2);
  assert.deepEqual(wrongs, []);
  await close();
});

test('the keyboard alone sends a goal', async () => {
  const { page, close } = await openPage(browser, url);
  await page.focus('#tool-goal');
  await page.keyboard.press('Space');
  assert.equal(await page.getAttribute('#tool-goal', 'aria-pressed'), 'true');
  await page.focus('.map-canvas');
  await page.keyboard.press('Enter');
  const { poses } = await asked('Navigate');
  // Under the cross, which is in the middle of the canvas.
  const at = await windowOf(page, poses[0].xM, poses[0].yM, 0);
  const box = await page.locator('.map-canvas').boundingBox();
  near(at.x, box.x + box.width / 2, 3);
  near(at.y, box.y + box.height / 2, 3);
  await page.click('#tool-goal');
  await page.keyboard.press('Escape');
  assert.equal(await page.getAttribute('#tool-look', 'aria-pressed'), 'true');
  await close();
});

test('axe-core finds no fault, in either tone', async () => {
  for (const colorScheme of ['light', 'dark']) {
    const { page, close } = await openPage(browser, url, { colorScheme });
    await text(page, '#mode', 'Ready');
    await assertAccessible(page, process.env.TREELINE_PAGE_WORK);
    await close();
  }
});

test('keys do what the help says', async () => {
  const { page, wrongs, close } = await openPage(browser, url);
  await page.keyboard.press('?');
  await page.waitForSelector('#help .popover:visible');
  assert.match(await page.textContent('#help'), /OctoMap, by height/);
  await page.keyboard.press('l');
  await page.waitForSelector('.layers .popover:visible');
  await page.waitForSelector('#help .popover', { state: 'hidden' });
  await page.keyboard.press('Escape');
  await page.waitForSelector('.layers .popover', { state: 'hidden' });
  for (const [key, tool] of [['g', 'goal'], ['p', 'pose'], ['Escape', 'look']]) {
    await page.keyboard.press(key);
    assert.equal(
        await page.getAttribute(`#tool-${tool}`, 'aria-pressed'), 'true', key);
  }
  await page.keyboard.press('f');
  assert.equal(await page.getAttribute('#follow', 'aria-pressed'), 'true');
  await page.keyboard.press('Space');
  await asked('Pause');
  // It is the button's own there.
  await page.focus('#find-yourself');
  await page.keyboard.press('Space');
  await asked('FindYourself');
  assert.equal(agent.asked.length, 2);
  assert.deepEqual(wrongs, []);
  await close();
});

for (const [what, view] of [['3D', '#view-3d'], ['the top', '#view-top']]) {
  test(`in ${what} all of the map is in the picture, and large`, async () => {
    const { page, close } = await openPage(browser, url);
    await page.click(view);
    const box = await page.locator('.map-canvas').boundingBox();
    const corners = [];
    // The corners of the canned world.
    for (const [x, y] of [[0, 0], [13, 0], [0, 10], [13, 10]]) {
      corners.push(await windowOf(page, x, y, 0));
    }
    const [left, right] = [Math.min, Math.max].map(
        (of) => of(...corners.map((corner) => corner.x)));
    const [top, bottom] = [Math.min, Math.max].map(
        (of) => of(...corners.map((corner) => corner.y)));
    assert.ok(left >= box.x && right <= box.x + box.width, `${left} ${right}`);
    // Not under the tools either.
    assert.ok(top >= box.y + 50 && bottom <= box.y + box.height - 60,
        `${top} ${bottom}`);
    assert.ok(right - left > 0.8 * box.width ||
        bottom - top > 0.6 * box.height, `${right - left} ${bottom - top}`);
    await close();
  });
}

test('a scale says how long a metre is', async () => {
  const { page, close } = await openPage(browser, url);
  await page.click('#view-top');
  const at = await page.waitForFunction(() => {
    const element = document.querySelector('#scale');
    const [begin, end] = [6, 7].map((x) => window.treeline.windowOf(x, 5, 0.5));
    const metres = parseFloat(element.textContent) /
        (element.textContent.includes('cm') ? 100 : 1);
    const wanted = metres * (end.x - begin.x);
    const width = element.getBoundingClientRect().width;
    return Math.abs(width / wanted - 1) < 0.1;
  }, null, { polling: 50 });
  assert.equal(await at.jsonValue(), true);
  await close();
});

test('a robot without a camera is not asked for pictures', async () => {
  agent.picture = null;
  agent.devices = agent.devices.filter(({ name }) => name !== 'camera');
  const { page, wrongs, close } = await openPage(browser, url);
  await text(page, '#camera', 'no camera picture');
  await page.click('text=Last question');
  await text(page, '#camera', 'No picture was sent');
  // An answer of 404 would be among them.
  assert.deepEqual(wrongs, []);
  await close();
});
