// The operator's page in a real browser, against the real treeline-agent with a
// simulated robot. TREELINE_AGENT: the program; TREELINE_PAGE: the built page;
// TREELINE_PAGE_WORK: where its packages are.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import { Agent } from './agent.js';
import { dragOnMap, launchServer, openPage, windowOf } from './browser.js';
import { connect, messages, node } from './packages.js';

// A click is as exact as a pixel, 2 to 3 cm on the map here, and a cell, 5 cm.
const CLICK_M = 0.12;
// The agent's own tolerance, 0.1 m, and what AMCL is off.
const ARRIVED_M = 0.25;

// Free floor of the cafe; the robot starts at (1.6, 7.9).
const FLOOR = [4.4, 5.2, 0];
const OTHER_FLOOR = [6.4, 4.9, 0];
const TERRACE_HEIGHT_M = 0.3;

let agent;
let browser;

before(async () => {
  [agent, browser] = await Promise.all([
    Agent.start(process.env.TREELINE_AGENT, process.env.TREELINE_PAGE,
        ['--simulate', 'cafe', '--people=false', '--speed', '4',
          '--camera-hz', '1']),
    launchServer(process.env.TREELINE_PAGE_WORK),
  ]);
});
after(async () => {
  agent?.kill();
  await browser?.kill();
});

const distance = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);
const point = ([x, y]) => ({ x, y });
const text = (page, selector, wanted) => page.waitForFunction(
    ([where, what]) => document.querySelector(where)?.textContent.includes(what),
    [selector, wanted], { polling: 50 });

test('a click on the floor brings the robot there', async () => {
  const asked = [];
  const { page, wrongs, close } = await openPage(browser.browser, agent.url, {
    viewport: { width: 900, height: 600 } }, null,
  (response) => asked.push([new URL(response.url()).pathname,
    response.status()]));
  for (const path of ['/api/octomap', '/api/levels/0.png',
    '/api/levels/0.heights']) {
    assert.deepEqual(asked.find(([name]) => name === path), [path, 200]);
  }
  await text(page, '#mode', 'Ready');
  const drawn = await page.evaluate(() => window.treeline.drawn());
  assert.equal(drawn.levels, 1);
  assert.ok(drawn.triangles > 10000, `${drawn.triangles} triangles`);
  await page.click('#tool-goal');
  await dragOnMap(page, FLOOR);
  await text(page, '#events', 'accepted');
  await text(page, '#goal', 'Arrived');
  const { goal, truth } = await agent.get('api/state');
  assert.equal(goal.state, 'succeeded');
  assert.ok(distance(goal.poses[0], point(FLOOR)) < CLICK_M,
      JSON.stringify(goal));
  assert.ok(distance(truth, goal.poses[0]) < ARRIVED_M, JSON.stringify(truth));
  assert.deepEqual(wrongs, []);
  await close();
});

test('a telephone sends a goal; the robot needs no browser for it', async () => {
  const { page, wrongs } = await openPage(browser.browser, agent.url, {
    viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true });
  const [pageWidth, windowWidth] = await page.evaluate(
      () => [document.documentElement.scrollWidth, window.innerWidth]);
  assert.equal(pageWidth, windowWidth);
  await page.tap('#tool-goal');
  const at = await windowOf(page, ...OTHER_FLOOR);
  await page.touchscreen.tap(at.x, at.y);
  await agent.stateWhere(({ goal }) => goal.id === 2);
  assert.deepEqual(wrongs, []);
  await browser.kill();
  const { goal, truth } = await agent.stateWhere(
      ({ goal: { state } }) => state !== 'active' && state !== 'accepted');
  assert.equal(goal.state, 'succeeded', JSON.stringify(goal));
  assert.ok(distance(truth, goal.poses[0]) < ARRIVED_M, JSON.stringify(truth));
});

test('the robot is kidnapped, and a box is put in its way', async () => {
  browser = await launchServer(process.env.TREELINE_PAGE_WORK);
  const { page, wrongs, close } = await openPage(browser.browser, agent.url);
  const { truth: before } = await agent.get('api/state');
  await page.click('#simulation summary');
  await page.selectOption('#place', 'terrace');
  await page.click('#kidnap-place');
  await text(page, '#events', 'the robot is lost');
  const { truth } = await agent.stateWhere(
      ({ truth: { height_m: height } }) => height > TERRACE_HEIGHT_M);
  assert.ok(distance(truth, before) > 1, JSON.stringify([before, truth]));
  await page.click('#tool-obstacle');
  await dragOnMap(page, FLOOR);
  await page.waitForSelector('#simulation >> text=Remove');
  const { obstacles } = await agent.get('api/scene');
  assert.equal(obstacles.length, 1);
  assert.ok(distance(obstacles[0], point(FLOOR)) < CLICK_M,
      JSON.stringify(obstacles));
  assert.deepEqual(wrongs, []);
  await close();
});

test('the page drives the robot by hand, stops it and releases it', async () => {
  const { page, wrongs, close } = await openPage(browser.browser, agent.url);
  await page.focus('#drive-pad');
  await page.keyboard.down('ArrowLeft');
  await agent.stateWhere(({ mode, command }) =>
    mode === 'manual' && command.yaw_rate_radps > 0.1);
  await page.keyboard.up('ArrowLeft');
  await agent.stateWhere(({ mode, command }) =>
    mode !== 'manual' && command.yaw_rate_radps === 0);
  await page.click('#stop');
  await text(page, '#stopped', 'Stopped until it is released');
  const { stop } = await agent.stateWhere(({ mode }) => mode === 'stopped');
  assert.match(stop.why, /page/);
  await page.click('#tool-goal');
  await dragOnMap(page, FLOOR);
  await text(page, '#toasts', 'the goal is refused');
  await page.click('#release');
  await agent.stateWhere(({ mode }) => mode !== 'stopped');
  await text(page, '#events', 'released after');
  assert.deepEqual(wrongs, []);
  await close();
});

test('a zone that is drawn on the page refuses goals until it is removed', async () => {
  const { page, wrongs, close } = await openPage(browser.browser, agent.url);
  const [x, y, z] = OTHER_FLOOR;
  await page.click('#tool-zone');
  for (const [dx, dy] of [[-0.7, -0.7], [0.7, -0.7], [0.7, 0.7], [-0.7, 0.7]]) {
    await dragOnMap(page, [x + dx, y + dy, z]);
  }
  await page.click('#zone-finish');
  await text(page, '#zones', 'Keep out 1');
  await text(page, '#events', 'zones have changed');
  await page.click('#tool-goal');
  await dragOnMap(page, OTHER_FLOOR);
  await text(page, '#toasts', 'lies in the keep-out zone \'Keep out 1\'');
  await page.click('#zones > summary');
  await page.click('#zones button');
  await text(page, '#zones', 'There are none');
  assert.deepEqual(wrongs, []);
  await close();
});

for (const format of ['binary', 'JSON']) {
  test(`others speak Connect in ${format}`, async () => {
    const client = connect.createClient(messages.NavigationService,
        node.createConnectTransport({ baseUrl: agent.url, httpVersion: '1.1',
          useBinaryFormat: format === 'binary' }));
    const info = await client.getInfo({});
    assert.equal(info.world, 'cafe');
    assert.equal(info.levels.length, 1);
    await client.pause({});
    let seen = 0;
    for await (const { state } of client.streamState({ withScene: true })) {
      if (state?.mode === messages.NavigatorMode.PAUSED) break;
      assert.ok(++seen < 100, 'it does not pause');
    }
    await client.resume({});
    await assert.rejects(client.cancel({ goalId: 999n }), (error) =>
      error instanceof connect.ConnectError &&
      error.code === connect.Code.NotFound);
    const far = client.navigate({ poses: [{ xM: 0, yM: 0, level: 99 }] });
    await assert.rejects(far[Symbol.asyncIterator]().next(), (error) =>
      error.code === connect.Code.InvalidArgument &&
      error.rawMessage.includes('level'));
  });
}

test('the agent ends as it should after all that', async () => {
  assert.equal(await agent.stop(), 0, agent.log);
});
