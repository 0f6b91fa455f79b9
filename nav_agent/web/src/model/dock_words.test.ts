import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Docking } from '../api/types.js';
import { dockDetail, freeDockName, sayDocking } from './dock_words.js';

const AWAY: Docking = {
  outcome: 'none', why: '', failedTries: 0, state: 'away', dock: '',
  charge: 'enough', chargeWhy: '',
};
const DOCK = {
  name: 'Dock 1', x: 1, y: 2, yaw: 0, level: 0, isBackward: true };

test('a robot that is in no dock and needs none says nothing', () => {
  assert.equal(sayDocking(null), null);
  assert.equal(sayDocking(AWAY), null);
  assert.equal(sayDocking({ ...AWAY, charge: 'off' }), null);
  assert.equal(sayDocking({ ...AWAY, outcome: 'cancelled', why: 'x' }), null);
});

test('what it does is said with why, and a failure is bad', () => {
  assert.deepEqual(
      sayDocking({ ...AWAY, outcome: 'under_way', state: 'driving_in',
        dock: 'A', charge: 'going', chargeWhy: "to dock 'A'",
        failedTries: 1 }),
      { title: 'Goes to charge, drives into A',
        text: "to dock 'A' — 1 of 3 tries in vain", tone: 'busy' });
  assert.deepEqual(
      sayDocking({ ...AWAY, outcome: 'failed', why: 'a closed door' }),
      { title: 'Docking failed', text: 'a closed door', tone: 'bad' });
  assert.equal(sayDocking({ ...AWAY, outcome: 'succeeded', why: '1 cm off',
    state: 'docked', dock: 'A', charge: 'charging' })?.title,
  'Charges, stands in A');
});

test('names are free, and details short', () => {
  assert.equal(freeDockName([]), 'Dock 1');
  assert.equal(freeDockName([DOCK]), 'Dock 2');
  assert.equal(dockDetail(DOCK, 1), 'backwards');
  assert.equal(dockDetail({ ...DOCK, isBackward: false }, 2),
      'forwards, level 0');
});
