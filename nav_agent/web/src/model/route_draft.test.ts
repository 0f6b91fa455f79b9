import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { RouteStatus } from '../api/types.js';
import {
  freeRouteName, isRouteOpen, mayGoOn, routeDetail, RouteDraft, sayRoute,
} from './route_draft.js';

const at = (x: number, y: number, level = 0, yaw: number | null = null) =>
  ({ x, y, yaw, level });

const statusOf = (fields: Partial<RouteStatus>): RouteStatus => ({
  id: 1, name: 'Patrol', state: 'driving', why: '', waypoint: 1, waypoints: 5,
  waypointName: '', isLoop: false, lap: 0, waited: 0, wait: 0, reached: 1,
  missed: 0, lastMissed: [], goalId: 1, warning: '', ...fields,
});

test('clicks make a route, and a double click one waypoint', () => {
  const draft = new RouteDraft();
  assert.equal(draft.add(at(0, 0)), true);
  assert.equal(draft.add(at(0.01, 0)), false);
  assert.equal(draft.add(at(0.01, 0, 1)), true);
  draft.setWait(12);
  draft.add(at(3, 0, 1, 0));
  draft.undo();
  assert.equal(draft.lastWait, 12);
  assert.deepEqual(draft.route(' a ', true, false), {
    name: 'a', isLoop: true, stopsAtMissed: false, waypoints: [
      { ...at(0, 0), wait: 0, name: '' },
      { ...at(0.01, 0, 1), wait: 12, name: '' },
    ],
  });
  draft.setWait(NaN);
  assert.equal(draft.lastWait, 0);
  draft.setWait(-3);
  assert.equal(draft.lastWait, 0);
  draft.setWait(1e9);
  assert.equal(draft.lastWait, 86400);
  draft.clear();
  draft.setWait(3);
  assert.equal(draft.lastWait, 0);
});

test('a route has at most a hundred waypoints', () => {
  const draft = new RouteDraft();
  for (let i = 0; i < 101; ++i) draft.add(at(i, 0));
  assert.equal(draft.waypoints.length, 100);
});

test('a new route has a name of its own', () => {
  const route = new RouteDraft().route('Route 1', false, false);
  assert.equal(freeRouteName([]), 'Route 1');
  assert.equal(freeRouteName([route]), 'Route 2');
});

test('a route is described by what it does', () => {
  const draft = new RouteDraft();
  draft.add(at(0, 0));
  assert.equal(routeDetail(draft.route('', false, false)), '1 waypoint');
  draft.add(at(1, 0));
  draft.setWait(5);
  assert.equal(routeDetail(draft.route('', true, true)),
      '2 waypoints, in a loop, waits 5 s, stops at a missed one');
});

test('progress names waypoint, lap and wait', () => {
  assert.equal(sayRoute(statusOf({})).title, 'Patrol: waypoint 2 of 5');
  assert.equal(sayRoute(statusOf({
    state: 'waiting', isLoop: true, lap: 2, waited: 3.7, wait: 10,
    waypointName: 'door', name: '',
  })).title, 'Route: waypoint 2 of 5 (door), lap 3, waits 3 of 10 s');
});

test('what is held, offered, or over says why', () => {
  const held = sayRoute(statusOf({ state: 'held', why: 'stopped' }));
  assert.equal(held.title, 'Patrol: waypoint 2 of 5, held');
  assert.equal(held.text, 'stopped');
  assert.equal(mayGoOn(statusOf({ state: 'offered' })), true);
  assert.equal(mayGoOn(statusOf({})), false);
  assert.equal(isRouteOpen(statusOf({ state: 'failed' })), false);
  const over = sayRoute(statusOf({
    state: 'succeeded', missed: 2, lastMissed: ['waypoint 3: no way'],
    warning: 'not kept' }));
  assert.equal(over.title, 'Patrol: done');
  assert.equal(over.text, '2 waypoints missed: waypoint 3: no way');
  assert.equal(over.tone, 'warn');
  // Of an agent that is newer.
  assert.equal(sayRoute(statusOf({ state: '' })).tone, 'calm');
});
