import assert from 'node:assert/strict';
import test from 'node:test';

import { create, type MessageInitShape } from '@bufbuild/protobuf';

import {
  GetInfoResponseSchema, GoalState, NavigationCause, NavigatorMode,
  RobotEventSchema, RobotSceneSchema, RobotStateSchema,
} from '../gen/treeline/v1/navigation_pb.js';
import {
  deviationsOf, eventOf, flatNumbers, infoOf, ProtoError, sceneOf, stateOf,
} from './from_proto.js';

const read = (fields: MessageInitShape<typeof RobotStateSchema>) =>
  stateOf(create(RobotStateSchema, fields));

test('a state of the robot is read in full', () => {
  const state = read({
    timeS: 3.5, mode: NavigatorMode.SAFE_STOP,
    cause: NavigationCause.LASER_LOST, causeText: 'no scan', advice: 'Look.',
    mapFromBase: { xM: 1, yM: 2, yawRad: 0.5, level: 1, heightM: 2.9 },
    covariance: [0.05, 0.03, 0, 0.03, 0.05, 0, 0, 0, 0.04],
    lostProbability: 0.2, lostState: 'localized', lostReason: 'none',
    forwardMps: 0.5, yawRateRadps: -0.1,
    goal: { id: 7n, state: GoalState.ACTIVE, toGoM: 4, drivenM: 1, replans: 2 },
    goalPoses: [{ xM: 5, yM: 6 }],
    fix: { localized: true, confidence: 0.9, inliers: 40, samples: 50,
      scene: 'cafe', roundTripS: 0.1, verdict: 'believed',
      mapFromBase: { xM: 1, yM: 2, yawRad: 0.3 } },
    devices: [{ name: 'laser', state: 'running', cause: '' }],
    trueMapFromBase: { xM: 1, yM: 2, yawRad: 0.4, heightM: 2.9 },
    missedDeadlines: 1n, steps: 140n,
  });
  assert.equal(state.mode, 'safe_stop');
  assert.equal(state.cause, 'laser_lost');
  assert.equal(state.pose?.level, 1);
  assert.equal(state.pose?.height, 2.9);
  assert.equal(state.pose?.stdYaw, 0.2);
  assert.equal(state.lost.probability, 0.2);
  assert.equal(state.goal?.id, 7);
  assert.equal(state.goal?.state, 'active');
  assert.equal(state.goal?.poses[0].y, 6);
  assert.equal(state.fix?.inliers, 40);
  assert.deepEqual(state.fix?.at, { x: 1, y: 2, yaw: 0.3 });
  assert.equal(state.truth?.yaw, 0.4);
  assert.equal(state.missedDeadlines, 1);
});

test('a robot in doubt names the other places', () => {
  const state = read({
    mapFromBase: { xM: 1, yM: 2 }, inDoubt: true, placeShare: 0.5,
    otherPlaces: [
      { mapFromBase: { xM: 5, yM: 6, yawRad: 1, level: 1, heightM: 3 },
        share: 0.4 },
      // Of a place that is not said, nothing is drawn.
      { share: 0.1 },
    ],
  });
  assert.equal(state.pose?.inDoubt, true);
  assert.equal(state.pose?.placeShare, 0.5);
  assert.deepEqual(state.pose?.others,
      [{ x: 5, y: 6, yaw: 1, level: 1, height: 3, share: 0.4 }]);
});

test('a robot that knows nothing yet has a state, too', () => {
  const state = read({});
  assert.equal(state.pose, null);
  assert.equal(state.goal, null);
  assert.equal(state.fix, null);
  assert.equal(state.truth, null);
  assert.equal(state.cause, 'none');
  assert.deepEqual(state.devices, []);
});

test('a fix without a place has none', () => {
  assert.equal(read({ fix: { reason: 'TOO_FEW_INLIERS' } }).fix?.at, null);
});

test('how sure a pose is follows from its covariance', () => {
  const { std, stdYaw } =
      deviationsOf([0.05, 0.03, 0, 0.03, 0.05, 0, 0, 0, 0.04]);
  // Its longer axis lies along x + y: 0.05 + 0.03.
  assert.ok(std !== null && Math.abs(std - Math.sqrt(0.08)) < 1e-12);
  assert.equal(stdYaw, 0.2);
  assert.deepEqual(deviationsOf([]), { std: null, stdYaw: null });
});

test('what is not finite is not drawn', () => {
  assert.throws(() => read({ timeS: NaN }), ProtoError);
  assert.throws(() => read({ mapFromBase: { xM: Infinity } }), /"x_m"/);
  assert.equal(read({ lostProbability: NaN }).lost.probability, 0);
  assert.deepEqual([...flatNumbers([1, NaN, 3, 4, 5], 2)], [3, 4]);
});

test('enumerators that a newer agent knows are not taken for others', () => {
  const state = read({ mode: 77 as NavigatorMode,
    goal: { id: 1n, state: 77 as GoalState } });
  assert.equal(state.mode, '');
  assert.equal(state.goal?.state, 'unknown');
});

test('a scene becomes flat arrays', () => {
  const scene = sceneOf(create(RobotSceneSchema, {
    path: [{ xM: 0, yM: 0, heightM: 0.5 }, { xM: 1, yM: 0, yawRad: 0.25 }],
    bubbles: [{ xM: 1, yM: 2, radiusM: 0.5 }],
    treeEdgesM: [0, 0, 1, 1], scanM: [1, 2, 3, 4], particles: [1, 2, 3],
    blockages: [{ xM: 1, yM: 2, radiusM: 0.4, level: 1 }],
    costmap: { originXM: -1, originYM: -2, resolutionM: 0.05, width: 2,
      height: 2, heightM: 1, cells: new Uint8Array([0, 1, 2, 0]) },
    obstacles: [{ name: 'box', xM: 1, yM: 2 }],
  }));
  assert.deepEqual([...scene.path], [0, 0, 0.5, 0, 1, 0, 0, 0.25]);
  assert.deepEqual([...scene.bubbles], [1, 2, 0, 0.5]);
  assert.deepEqual(
      scene.blockages, [{ x: 1, y: 2, radius: 0.4, level: 1 }]);
  assert.deepEqual([...scene.costmap?.cells ?? []], [0, 1, 2, 0]);
  assert.deepEqual(scene.costmap?.origin, [-1, -2]);
  assert.deepEqual(scene.obstacles, [{ name: 'box', x: 1, y: 2 }]);
});

test('a costmap of another size than it says is refused', () => {
  const costmap = { width: 3, height: 2, cells: new Uint8Array(4) };
  assert.throws(
      () => sceneOf(create(RobotSceneSchema, { costmap })), /3 x 2 bytes/);
});

test('the map is read with its levels', () => {
  const info = infoOf(create(GetInfoResponseSchema, {
    version: '1', mapName: 'cafe', levels: [{ width: 10, height: 5,
      resolutionM: 0.05, originXM: -1, originYM: -2, originYawRad: 0.1 }],
    robot: { frontM: 0.4, rearM: 0.3, halfWidthM: 0.2 },
    simulated: true, world: 'cafe', places: ['bar'],
  }));
  assert.deepEqual(info.levels[0].origin, [-1, -2, 0.1]);
  assert.equal(info.robot.front, 0.4);
  assert.deepEqual(info.places, ['bar']);
  assert.throws(() => infoOf(create(GetInfoResponseSchema,
      { levels: [{ width: 1, height: 1 }] })), /resolution_m/);
});

test('an event has its number and time', () => {
  assert.deepEqual(eventOf(create(RobotEventSchema,
      { number: 3n, timeS: 1.5, kind: 'plan', text: 'a path' })),
  { number: 3, time: 1.5, kind: 'plan', text: 'a path' });
});
