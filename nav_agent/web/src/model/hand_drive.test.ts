import assert from 'node:assert/strict';
import { test } from 'node:test';

import {
  FASTEST_MPS, FASTEST_RADPS, HandDrive, isDrivingKey, velocityOf,
  velocityOfKeys, type Velocity,
} from './hand_drive.js';

test('the pad gives a velocity, at its edge the fastest', () => {
  assert.deepEqual(velocityOf(0, 0), { forward: 0, yawRate: 0 });
  assert.deepEqual(velocityOf(0.05, 0.1), { forward: 0, yawRate: 0 });
  assert.equal(velocityOf(0, 1).forward, FASTEST_MPS);
  assert.equal(velocityOf(0, -5).forward, -FASTEST_MPS);
  // To the right is clockwise.
  assert.equal(velocityOf(1, 0).yawRate, -FASTEST_RADPS);
  assert.ok(velocityOf(0, 0.5).forward < 0.5 * FASTEST_MPS);
  assert.deepEqual(velocityOf(NaN, 1), { forward: 0, yawRate: 0 });
});

test('keys add up', () => {
  assert.ok(isDrivingKey('ArrowUp') && isDrivingKey('W'));
  assert.ok(!isDrivingKey('q'));
  assert.deepEqual(velocityOfKeys(['ArrowUp', 'ArrowDown']),
      { forward: 0, yawRate: 0 });
  const { forward, yawRate } = velocityOfKeys(['ArrowUp', 'a']);
  assert.ok(forward > 0 && yawRate > 0);
});

function world() {
  const sent: [Velocity, bigint][] = [];
  const answers: { resolve: () => void; reject: (e: Error) => void }[] = [];
  const state = { tick: null as (() => void) | null, refused: 0,
    moves: false };
  const drive = new HandDrive({
    send: (velocity, sequence) => {
      sent.push([velocity, sequence]);
      return new Promise((resolve, reject) => {
        answers.push({ resolve, reject });
      });
    },
    every: (work) => {
      state.tick = work;
      return () => { state.tick = null; };
    },
    isPassing: (error) => error instanceof RangeError,
    refused: () => { ++state.refused; },
    moves: (isDriven) => { state.moves = isDriven; },
  });
  return { sent, answers, state, drive };
}

const settled = () => new Promise((resolve) => { setTimeout(resolve); });
const ahead = { forward: 0.3, yawRate: 0 };

test('what is held is said again, and its release at once', async () => {
  const { sent, answers, state, drive } = world();
  drive.hold(ahead);
  answers[0].resolve();
  await settled();
  state.tick?.();
  drive.release();
  assert.equal(state.tick, null);
  assert.equal(state.moves, false);
  assert.deepEqual(sent.map(([velocity]) => velocity.forward), [0.3, 0.3, 0]);
  assert.deepEqual(sent.map(([, sequence]) => sequence), [1n, 2n, 3n]);
  drive.release();
  assert.equal(sent.length, 3);
});

test('on a slow line no more is sent than it takes; a stop always', () => {
  const { sent, state, drive } = world();
  drive.hold(ahead);
  for (let i = 0; i < 20; ++i) state.tick?.();
  assert.equal(sent.length, 3);
  drive.release();
  assert.equal(sent.length, 4);
  assert.equal(sent[3][0].forward, 0);
});

test('a command that comes late ends nothing', async () => {
  const { answers, state, drive } = world();
  drive.hold(ahead);
  answers[0].reject(new RangeError('late'));
  await settled();
  assert.equal(drive.isDriven, true);
  assert.equal(state.refused, 0);
});

test('a refusal ends the drive, and is said once', async () => {
  const { answers, state, drive } = world();
  drive.hold(ahead);
  state.tick?.();
  answers[0].reject(new Error('stopped'));
  answers[1].reject(new Error('stopped'));
  await settled();
  assert.equal(state.refused, 1);
  assert.equal(drive.isDriven, false);
});
