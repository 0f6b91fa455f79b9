import assert from 'node:assert/strict';
import test from 'node:test';

import type { Goal, RobotState } from '../api/types.js';
import { headingOf, headingTowards, turnBetween } from './gesture.js';
import { cutHeight, NO_CUT_M, shownLevel } from './levels.js';
import {
  clockOf, degrees, isPaused, knowsPlace, metres, percent, plain, sayBattery,
  sayDoubt,
  sayFix, sayGoal, sayState, signed,
} from './words.js';

const stateOf = (fields: Partial<RobotState>): RobotState => ({
  time: 0, mode: '', cause: 'none', causeText: '', advice: '', pose: null,
  lost: { probability: 0, state: 'localized', reason: 'none' },
  command: { forward: 0, yawRate: 0 }, goal: null, fix: null, devices: [],
  truth: null,
  stop: null, missedDeadlines: 0, zonesRevision: 0, route: null, routesRevision: 0,
  battery: null,
  docking: null,
  docksRevision: -1,
  steps: 0, ...fields,
});

const goalOf = (fields: Partial<Goal>): Goal => ({
  id: 1, state: 'active', cause: 'none', why: '', toGo: 3.2, driven: 1,
  replans: 0, recoveries: 0, poses: [], ...fields,
});

const doubtOf = (
    probability: number, state: string, mode = 'driving', reason = 'none') =>
  sayDoubt(stateOf({ mode, lost: { probability, state, reason } }));

test('modes have plain words, whatever their spelling', () => {
  assert.equal(sayState(stateOf({ mode: 'safe_stop' })).title, 'Safe stop');
  assert.equal(sayState(stateOf({ mode: 'safe stop' })).tone, 'bad');
  assert.equal(sayState(stateOf({ mode: 'need_help' })).title, 'Needs help');
  assert.equal(isPaused(stateOf({ mode: 'Paused' })), true);
});

test('a mode that is not known is still named', () => {
  assert.equal(sayState(stateOf({ mode: 'parking_up' })).title, 'Parking up');
  assert.equal(sayState(stateOf({})).title, 'Unknown');
});

test('the cause is what is said, if there is one', () => {
  assert.equal(sayState(stateOf({ mode: 'safe_stop', cause: 'laser_lost',
    causeText: 'No scan for 0.4 s.' })).text, 'No scan for 0.4 s.');
  assert.equal(sayState(stateOf({ mode: 'safe_stop', cause: 'laser_lost' }))
      .text, 'Laser lost.');
  assert.equal(sayState(stateOf({ mode: 'relocalizing',
    cause: 'estimate_lost', causeText: 'searching' })).text, 'Searching.');
  assert.equal(sayState(stateOf({ mode: 'idle', cause: 'none' })).text,
      'Waiting for a goal.');
});

test('numbers are short', () => {
  assert.equal(metres(3.14159), '3.1 m');
  assert.equal(metres(14.2), '14 m');
  assert.equal(signed(-0.1, 2), '\u22120.10');
  assert.equal(signed(-0.001, 2), '0.00');
  assert.equal(degrees(-Math.PI / 2), '\u221290°');
  assert.equal(degrees(-0.001), '0°');
  assert.equal(percent(0.934), '93 %');
  assert.equal(percent(7), '100 %');
  assert.equal(clockOf(75.9), '1:15');
  assert.equal(clockOf(3725), '1:02:05');
  assert.equal(plain('goal_blocked'), 'Goal blocked');
});

test('being lost is said with its reason', () => {
  assert.equal(doubtOf(1, 'lost', 'lost', 'scans do not fit').text,
      'Does not know its place: scans do not fit');
  assert.equal(doubtOf(0, 'localized').text, 'Localized');
  assert.equal(doubtOf(0.1, 'people nearby').text,
      'Localized; people are nearby');
});

test('a robot that is probably lost does not "know its place"', () => {
  for (const verdict of ['localized', 'map changed here', 'people nearby']) {
    const doubt = doubtOf(0.69, verdict);
    assert.equal(doubt.title, '69 %');
    assert.equal(doubt.text, 'Is not sure of its place');
    assert.equal(doubt.tone, 'warn');
  }
  assert.equal(doubtOf(0.8, 'localized').tone, 'bad');
  assert.equal(doubtOf(0.29, 'localized').text, 'Localized');
});

test('a robot that looks for its place does not know it either', () => {
  // The verdict begins anew with each place that is tried.
  const doubt = doubtOf(0.04, 'localized', 'relocalizing');
  assert.deepEqual(doubt,
      { title: 'Yes', text: 'Looks for its place', tone: 'bad', share: 1 });
  assert.equal(doubtOf(0.85, 'lost', 'safe_stop').title, '85 %');
  assert.equal(doubtOf(0.1, 'localized', 'need_help').text,
      'Does not know its place');
});

test('a robot in doubt says how many places look alike', () => {
  const other = { x: 1, y: 2, yaw: 0, level: 0, height: 0, share: 0.4 };
  const say = (others: (typeof other)[], probability = 0.04) =>
    sayDoubt(stateOf({ mode: 'driving',
      pose: { x: 1, y: 2, yaw: 0, level: 0, height: 0, std: 0.06, stdYaw: 0.03,
        inDoubt: true, placeShare: 0.5, others },
      lost: { probability, state: 'localized', reason: 'none' } }));
  assert.equal(say([other]).text, 'In doubt: one other place looks alike');
  assert.equal(say([other, other]).text,
      'In doubt: 2 other places look alike');
  assert.equal(say([]).text, 'In doubt: looks for places that are alike');
  assert.equal(say([other]).tone, 'warn');
  // A robot that is lost is not only in doubt.
  assert.equal(say([other], 0.9).tone, 'bad');
});

test('a pose that the robot does not believe is not its place', () => {
  const pose = { x: 1, y: 2, yaw: 0, level: 0, height: 0, std: 0.06,
    stdYaw: 0.03, inDoubt: false, placeShare: 1, others: [] };
  const lost = { probability: 0.9, state: 'lost', reason: 'none' };
  assert.equal(knowsPlace(stateOf({ mode: 'driving', pose })), true);
  assert.equal(knowsPlace(stateOf({ mode: 'driving' })), false);
  assert.equal(knowsPlace(stateOf({ mode: 'driving', pose, lost })), false);
  for (const mode of ['lost', 'relocalizing', 'need_help']) {
    assert.equal(knowsPlace(stateOf({ mode, pose })), false);
  }
});

test('a robot that drives is on the way, with how far it is', () => {
  const line = (mode: string, fields: Partial<Goal> = {}) =>
    sayGoal(goalOf(fields), stateOf({ mode }));
  assert.equal(line('driving').title, 'On the way: 3.2 m to go');
  assert.equal(line('recovering').title, 'On the way: 3.2 m to go');
  assert.equal(line('idle', { state: 'accepted', toGo: 0 }).title,
      'Goal accepted.');
  assert.equal(line('idle', { state: 'failed', why: 'no way' }).title,
      'Not reached.');
});

test('a goal is not "on the way" while the robot stands', () => {
  const line = (mode: string) => sayGoal(goalOf({}), stateOf({ mode }));
  for (const mode of ['lost', 'relocalizing', 'need_help']) {
    // How far it is nobody knows.
    assert.equal(line(mode).title, 'Waits until the robot knows its place.');
    assert.equal(line(mode).tone, 'warn');
  }
  assert.equal(line('paused').title, 'Waits for Resume: 3.2 m to go');
  assert.equal(line('safe stop').title,
      'Waits until the robot may drive: 3.2 m to go');
  assert.equal(line('planning').title, 'Looking for a way.');
});

test('an answer of the server is said with what became of it', () => {
  const fix = { localized: true, confidence: 1, inliers: 1, samples: 1,
    scene: '', reason: '', roundTrip: null, verdict: 'not on free ground',
    at: null };
  assert.equal(sayFix(fix), 'Not on free ground');
  assert.equal(sayFix({ ...fix, localized: false, reason: 'TOO_FEW_INLIERS' }),
      'Not recognized: too few inliers');
});

test('a drag is a heading, a click the one there was', () => {
  const from = { x: 0, y: 0 };
  assert.equal(headingOf(from, { x: 0, y: 2 }, 40, 0), Math.PI / 2);
  assert.equal(headingOf(from, { x: 0, y: 2 }, 4, 0.3), 0.3);
  assert.equal(headingOf(from, from, 40, 0.3), 0.3);
  assert.equal(headingTowards({ x: 1, y: 1 }, { x: 0, y: 1 }), Math.PI);
  assert.equal(headingTowards(null, { x: 0, y: 1 }), 0);
});

test('turns go the shorter way around', () => {
  const half = turnBetween(3, -3, 0.5);
  assert.ok(Math.abs(half - Math.PI) < 1e-9, String(half));
});

test('the shown level is the picked one, else the robot\'s', () => {
  assert.equal(shownLevel(null, 1, 2), 1);
  assert.equal(shownLevel(0, 1, 2), 0);
  assert.equal(shownLevel(null, null, 2), 0);
  assert.equal(shownLevel(7, 0, 2), 1);
});

test('the map is cut above the robot, if it is on the shown level', () => {
  assert.equal(cutHeight(1, 0, { level: 0, height: 0.5 }, 0), 1.5);
  assert.equal(cutHeight(1, 3, { level: 0, height: 0.5 }, 1), 4);
  assert.equal(cutHeight(NO_CUT_M, 0, null, 0), Infinity);
});

test('a battery says what it tells, and nothing else', () => {
  assert.equal(sayBattery(null), '');
  assert.equal(sayBattery({ volts: 0, charge: null, charging: false }), '');
  assert.equal(
      sayBattery({ volts: 74.52, charge: null, charging: false }), '74.5 V');
  assert.equal(sayBattery({ volts: 24, charge: 0.756, charging: true }),
      '76 % · 24.0 V · charges');
});

test('a robot that waits on its route says for how long', () => {
  const route = {
    id: 1, name: '', state: 'waiting', why: '', waypoint: 0, waypoints: 2,
    waypointName: '', isLoop: false, lap: 0, waited: 2.5, wait: 10, reached: 1,
    missed: 0, lastMissed: [], goalId: 1, warning: '',
  };
  assert.deepEqual(sayState(stateOf({ mode: 'idle', route })),
      { title: 'Waiting', text: 'At a waypoint, for 8 s.', tone: 'busy' });
  assert.equal(sayState(stateOf({ mode: 'paused', route })).title, 'Paused');
});
