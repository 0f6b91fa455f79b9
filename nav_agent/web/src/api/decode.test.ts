import assert from 'node:assert/strict';
import test from 'node:test';

import {
  DecodeError, decodeEvent, decodeInfo, decodeScene, decodeState, flatNumbers,
} from './decode.js';

test('a state of the robot is read in full', () => {
  const state = decodeState({
    time_s: 3.5, mode: 'driving', cause: 'none', cause_text: '', advice: '',
    pose: { x: 1, y: 2, yaw: 0.5, level: 1, height_m: 2.9, std_m: 0.05,
      std_rad: null },
    lost: { probability: 0.2, state: 'localized', reason: 'none' },
    command: { forward_mps: 0.5, yaw_rate_radps: -0.1 },
    goal: { id: 7, state: 'active', cause: 'none', why: '', to_go_m: 4,
      driven_m: 1, replans: 2, recoveries: 0,
      poses: [{ x: 5, y: 6, yaw: 0, level: 0 }] },
    fix: { localized: true, confidence: 0.9, inliers: 40, samples: 50,
      scene: 'cafe', round_trip_s: 0.1, verdict: 'believed', x: 1, y: 2,
      yaw: 0 },
    devices: [{ name: 'laser', state: 'running', cause: '' }],
    truth: { x: 1, y: 2, yaw: 0.4, height_m: 2.9 },
    missed_deadlines: 1, steps: 140,
  });
  assert.equal(state.pose?.level, 1);
  assert.equal(state.pose?.height, 2.9);
  assert.equal(state.pose?.stdYaw, null);
  assert.equal(state.goal?.poses[0].y, 6);
  assert.equal(state.fix?.inliers, 40);
  assert.deepEqual(state.fix?.at, { x: 1, y: 2, yaw: 0 });
  assert.equal(state.truth?.yaw, 0.4);
  assert.equal(state.missedDeadlines, 1);
});

test('a robot that knows nothing yet has a state, too', () => {
  const state = decodeState({ time_s: 0, mode: 'lost', pose: null, goal: null,
    fix: null, truth: null, lost: { probability: null } });
  assert.equal(state.pose, null);
  assert.equal(state.goal, null);
  assert.equal(state.lost.probability, 0);
  assert.deepEqual(state.devices, []);
});

test('wrong shapes are named', () => {
  assert.throws(() => decodeState(null), DecodeError);
  assert.throws(() => decodeState([]), /"state" is not an object/);
  assert.throws(() => decodeState({ mode: 'idle' }), /"time_s"/);
  assert.throws(
      () => decodeState({ time_s: 1, pose: { x: 'a', y: 1 } }), /"x"/);
  assert.throws(() => decodeState({ time_s: 1, devices: {} }), /"devices"/);
  assert.throws(() => decodeEvent({ number: 'one' }), /"number"/);
});

test('a state of a goal that is not known is not taken for another', () => {
  const state = decodeState({ time_s: 0, goal: { id: 1, state: 'dreaming' } });
  assert.equal(state.goal?.state, 'unknown');
});

test('flat and nested numbers read the same', () => {
  assert.deepEqual([...flatNumbers([1, 2, 3, 4], 2, 'n')], [1, 2, 3, 4]);
  assert.deepEqual([...flatNumbers([[1, 2], [3, 4]], 2, 'n')], [1, 2, 3, 4]);
  assert.deepEqual([...flatNumbers(undefined, 2, 'n')], []);
});

test('groups with something else in them, and rests, are left out', () => {
  assert.deepEqual([...flatNumbers([1, null, 3, 4, 5], 2, 'n')], [3, 4]);
});

test('a scene is read, its costmap from base64', () => {
  const scene = decodeScene({
    path: [[0, 0, 0.1, 0], [1, 0, 0.1, 0]], bubbles: [[1, 2, 0, 0.5]],
    tree: [0, 0, 1, 1], scan: [1, 2, 3, 4], particles: [1, 2, 3],
    blockages: [[1, 2, 0.4, 1]],
    costmap: { origin: [-1, -2], resolution_m: 0.05, width: 2, height: 2, z: 1,
      cells: 'AAECAA==' },
    obstacles: [{ name: 'box', x: 1, y: 2 }],
  });
  assert.equal(scene.path.length, 8);
  assert.deepEqual(scene.blockages, [
    { x: 1, y: 2, radius: Math.fround(0.4), level: 1 }]);
  assert.deepEqual([...scene.costmap?.cells ?? []], [0, 1, 2, 0]);
  assert.deepEqual(scene.costmap?.origin, [-1, -2]);
});

test('a costmap of another size than it says is refused', () => {
  const costmap = { origin: [0, 0], resolution_m: 0.05, width: 3, height: 2,
    z: 0, cells: 'AAECAA==' };
  assert.throws(() => decodeScene({ costmap }), /3 x 2 bytes/);
  assert.throws(
      () => decodeScene({ costmap: { ...costmap, cells: '*' } }), /base64/);
});

test('the map is read with its levels', () => {
  const info = decodeInfo({ version: '1', map: { name: 'cafe', levels: [
    { index: 0, width: 10, height: 5, resolution_m: 0.05, origin: [-1, -2, 0.1],
      min_height_m: 0, max_height_m: 0.5 }] },
  robot: { front_m: 0.4, rear_m: 0.3, half_width_m: 0.2 },
  simulated: true, world: 'cafe', places: ['bar', 3], server: '' });
  assert.deepEqual(info.levels[0].origin.map((n) => Math.round(10 * n)),
      [-10, -20, 1]);
  assert.equal(info.robot.front, 0.4);
  assert.deepEqual(info.places, ['bar']);
  assert.throws(() => decodeInfo({ map: { levels: [
    { index: 0, width: 1, height: 1, resolution_m: 0 }] } }), /resolution_m/);
});
