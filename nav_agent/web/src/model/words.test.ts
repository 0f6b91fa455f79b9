import assert from 'node:assert/strict';
import test from 'node:test';

import { decodeState } from '../api/decode.js';
import { headingOf, headingTowards, turnBetween } from './gesture.js';
import { cutHeight, NO_CUT_M, shownLevel } from './levels.js';
import {
  clockOf, degrees, isPaused, metres, percent, plain, sayFix, sayLost, sayState, signed,
} from './words.js';

const stateOf = (fields: object) => decodeState({ time_s: 0, ...fields });

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
    cause_text: 'No scan for 0.4 s.' })).text, 'No scan for 0.4 s.');
  assert.equal(sayState(stateOf({ mode: 'safe_stop', cause: 'laser_lost' }))
      .text, 'Laser lost.');
  assert.equal(sayState(stateOf({ mode: 'relocalizing',
    cause: 'estimate_lost', cause_text: 'searching' })).text, 'Searching.');
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
  assert.equal(
      sayLost({ probability: 1, state: 'lost', reason: 'scans do not fit' }),
      'Does not know its place: scans do not fit');
  assert.equal(
      sayLost({ probability: 0, state: 'localized', reason: 'none' }),
      'Knows its place');
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
