// What is drawn on the operator's page, in a real browser, against an agent that
// the test plays: zones, routes and docks. Environment as page_test.js.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import { after, before, beforeEach, afterEach, test } from 'node:test';

import { dragOnMap, launch, openPage } from './browser.js';
import { near, text } from './checks.js';
import { MockAgent } from './mock_agent.js';
import { dockMessages, routeMessages } from './packages.js';

let browser;
let agent;
let url;

before(async () => {
  browser = await launch(process.env.TREELINE_PAGE_WORK);
});
after(() => browser?.close());
beforeEach(async () => {
  agent = new MockAgent({ pageFolder: process.env.TREELINE_PAGE,
    picture: fs.readFileSync(process.env.TREELINE_PICTURE) });
  url = await agent.listen();
});
afterEach(() => agent.vanish());

// Waits for the agent, not for a time: what it was asked, `times` at least.
async function asked(method, times = 1) {
  for (let i = 0; i < 1500; ++i) {
    const all = agent.asked.filter((entry) => entry.method === method);
    if (all.length >= times) return all.at(-1).body;
    await new Promise((resolve) => { setTimeout(resolve, 20); });
  }
  assert.fail(`${method} was not asked ${times} times`);
  return undefined;
}

test('a zone is drawn corner by corner, listed and removed', async () => {
  const { page, wrongs, close } = await openPage(browser, url, {}, /400/);
  await page.click('#tool-zone');
  await page.selectOption('#zone-kind', 'one-way');
  assert.equal(await page.isDisabled('#zone-finish'), true);
  for (const [x, y] of [[3.0, 3.0], [3.0, 5.0], [6.0, 5.0], [6.0, 3.0]]) {
    await dragOnMap(page, [x, y, 0]);
  }
  await text(page, '.zone-hint', '4 corners');
  await page.click('#zone-undo');
  await text(page, '.zone-hint', '3 corners');
  // A click that missed is taken back; the refusal of the agent leaves the rest.
  agent.refusals.set('PutZones', 'zone crosses itself');
  await page.click('#zone-finish');
  await text(page, '.toasts', 'crosses itself');
  agent.refusals.clear();
  await dragOnMap(page, [6.0, 3.0, 0]);
  await page.click('#zone-finish:enabled');
  await text(page, '#zones', 'One way 1');
  const { zones } = agent.lastAsked('PutZones');
  assert.equal(zones.length, 1);
  assert.equal(zones[0].corners.length, 4);
  near(zones[0].corners[0].xM, 3);
  near(zones[0].corners[1].yM, 5);
  // As its first side was drawn.
  near(zones[0].directionRad, Math.PI / 2, 0.1);
  assert.equal(await page.getAttribute('#tool-look', 'aria-pressed'), 'true');
  await page.click('#zones > summary');
  await page.click('#zones button');
  assert.deepEqual((await asked('RemoveZones')).names, ['One way 1']);
  await text(page, '#zones', 'There are none');
  assert.deepEqual(wrongs, []);
  await close();
});

test('a route is drawn waypoint by waypoint, run, kept and removed', async () => {
  const { page, wrongs, close } = await openPage(browser, url, {}, /400/);
  await page.click('#tool-route');
  assert.equal(await page.isDisabled('#route-run'), true);
  await dragOnMap(page, [3.0, 3.0, 0]);
  await page.fill('#route-wait', '7');
  // A drag is a heading, too; a click that missed is taken back.
  await dragOnMap(page, [6.0, 5.0, 0], [6.0, 6.5, 0]);
  await dragOnMap(page, [6.0, 3.0, 0]);
  await text(page, '#route-hint', '3 waypoints');
  await page.click('#route-undo');
  await text(page, '#route-hint', '2 waypoints');
  await page.check('#route-loop');
  agent.refusals.set('PutRoutes', 'route leads nowhere');
  await page.click('#route-save');
  await text(page, '.toasts', 'leads nowhere');
  agent.refusals.clear();
  await page.fill('#route-name', 'Patrol');
  await page.click('#route-save:enabled');
  await text(page, '#routes', 'Patrol');
  await page.click('#route-run:enabled');
  const { what } = await asked('RunRoute');
  assert.equal(what.case, 'route');
  const { waypoints, loop, whenMissed } = what.value;
  assert.equal(loop, true);
  assert.equal(whenMissed, 1);
  assert.equal(waypoints.length, 2);
  near(waypoints[0].xM, 3);
  assert.equal(waypoints[0].waitS, 7);
  assert.equal(waypoints[0].yawRad, undefined);
  near(waypoints[1].yawRad, Math.PI / 2, 0.1);
  await text(page, '#route', 'Patrol: waypoint 1 of 2, lap 1');
  assert.equal(await page.getAttribute('#tool-look', 'aria-pressed'), 'true');
  await page.click('#routes > summary');
  await text(page, '#routes', '2 waypoints, in a loop, waits 7 s');
  await page.click('[aria-label="Run Patrol"]');
  assert.deepEqual((await asked('RunRoute', 2)).what,
      { case: 'kept', value: 'Patrol' });
  await page.click('[aria-label="Remove Patrol"]');
  assert.deepEqual((await asked('RemoveRoutes')).names, ['Patrol']);
  await text(page, '#routes', 'None is kept');
  assert.deepEqual(wrongs, []);
  await close();
});

test('a route says how far it is, and goes on when somebody says so', async () => {
  const { page, wrongs, close } = await openPage(browser, url);
  const { RouteState } = routeMessages;
  assert.equal(await page.isVisible('#route'), false);
  agent.begin({ name: 'Patrol', waypoints: [
    { xM: 3, yM: 3, name: 'door', waitS: 10 }, { xM: 6, yM: 3, name: '' }] });
  Object.assign(agent.route, { state: RouteState.OFFERED, waypoint: 1,
    waypointName: '',
    why: 'it was under way when the agent ended', missed: 1n,
    lastMissed: [{ waypoint: 0, why: 'no way' }] });
  await text(page, '#route', 'waypoint 2 of 2, not resumed yet');
  await text(page, '#route-why', '1 waypoint missed: waypoint 1: no way');
  await page.click('#route-resume');
  await asked('ResumeRoute');
  await page.waitForSelector('#route-resume', { state: 'hidden' });
  await text(page, '#route', 'Patrol: waypoint 2 of 2');
  agent.route = { ...agent.route, state: RouteState.WAITING, waitedS: 3.2,
    waitS: 10 };
  await text(page, '#mode', 'Waiting');
  await text(page, '#route', 'waits 3 of 10 s');
  // Of a robot that is stopped a route is not to go on.
  agent.route = { ...agent.route, state: RouteState.HELD, why: 'stopped' };
  agent.stopped = { why: 'a child', sinceS: 1 };
  await text(page, '#route', 'held');
  await page.waitForSelector('#route-resume:disabled');
  agent.stopped = undefined;
  await page.waitForSelector('#route-resume:enabled');
  assert.equal(await page.isDisabled('#cancel'), false);
  await page.click('#route-cancel');
  await asked('CancelRoute');
  await text(page, '#route', 'Patrol: given up');
  assert.equal(await page.isVisible('#route-cancel'), false);
  assert.deepEqual(wrongs, []);
  await close();
});

test('a dock is made, driven into, watched and removed', async () => {
  const { page, wrongs, close } = await openPage(browser, url, {}, /400/);
  const { ChargeState, DockingOutcome, DockingState } = dockMessages;
  await page.click('#docks > summary');
  await text(page, '#docks', 'There are none');
  assert.equal(await page.inputValue('#dock-name'), 'Dock 1');
  await page.fill('#dock-name', 'Charger');
  await page.click('#dock-here');
  await text(page, '#docks ul', 'Charger');
  const here = await asked('PutDocks');
  assert.equal(here.here, true);
  assert.equal(here.docks[0].name, 'Charger');
  // The next one is drawn; a refusal is told.
  await page.check('#dock-backward');
  agent.refusals.set('PutDocks', 'it lies in a wall');
  await page.click('#tool-dock');
  await dragOnMap(page, [3, 3, 0], [3, 4, 0]);
  await text(page, '.toasts', 'lies in a wall');
  agent.refusals.clear();
  await page.click('#tool-dock');
  await dragOnMap(page, [3, 3, 0], [3, 4, 0]);
  await text(page, '#docks ul', 'Dock 1');
  const drawn = await asked('PutDocks', 3);
  assert.equal(drawn.here, false);
  near(drawn.docks[0].xM, 3);
  near(drawn.docks[0].yawRad, Math.PI / 2, 0.1);
  assert.equal(drawn.docks[0].backward, true);
  await page.click('[aria-label="Dock in Charger"]');
  assert.equal((await asked('Dock')).name, 'Charger');
  await text(page, '#docking', 'Drives to Charger');
  // There is no goal any more while it drives in.
  await page.waitForSelector('#cancel:enabled');
  agent.docking = { ...agent.docking, state: DockingState.DOCKED,
    outcome: DockingOutcome.SUCCEEDED, chargeState: ChargeState.CHARGING };
  await text(page, '#docking', 'Charges, stands in Charger');
  await page.click('#dock-out');
  await asked('Undock');
  agent.docking = { state: DockingState.AWAY, why: 'a closed door',
    outcome: DockingOutcome.FAILED, chargeState: ChargeState.LOW,
    chargeWhy: 'a closed door' };
  await text(page, '#docking', 'Battery low, docking failed');
  await text(page, '#docking-why', 'a closed door');
  await page.click('[aria-label="Remove Charger"]');
  assert.deepEqual((await asked('RemoveDocks')).names, ['Charger']);
  assert.deepEqual(wrongs, []);
  await close();
});
