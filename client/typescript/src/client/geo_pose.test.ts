import assert from 'node:assert/strict';
import { test } from 'node:test';

import { geoPoseAnswerOf, toBasicQuaternion, toBasicYpr } from './geo_pose.js';
import { angleBetweenRad, fromAxisAngle, multiply, normalized, type Quaternion }
  from '../geometry/rotation.js';

// As the server answers.
const answerWith = (quaternion: Quaternion) => ({
  id: '1', timestamp: 1764000000123, type: 'geopose',
  accuracy: { position: 0.02, orientation: 0.5 },
  geopose: { position: { lat: 48.137018, lon: 11.5750134, h: 523 },
    quaternion },
});

const about = (axis: 'x' | 'y' | 'z', deg: number) => fromAxisAngle(
    { x: 0, y: 0, z: 0, [axis]: deg * Math.PI / 180 });

const fromYpr = (yaw: number, pitch: number, roll: number) => multiply(
    multiply(about('z', yaw), about('y', pitch)), about('x', roll));

test('an answer is written as the server wrote it, and nothing else', () => {
  for (const [yaw, pitch, roll] of [[0, 0, 0], [130, -20, 40],
    [-170, 80, 179]] as const) {
    const said = answerWith(normalized(fromYpr(yaw, pitch, roll)));
    const written = toBasicQuaternion(geoPoseAnswerOf(said));
    assert.deepEqual(written.position, said.geopose.position);
    assert.deepEqual(Object.keys(written), ['position', 'quaternion']);
    for (const axis of ['x', 'y', 'z', 'w'] as const) {
      assert.ok(Math.abs(written.quaternion[axis] -
          said.geopose.quaternion[axis]) < 1e-12);
    }
    assert.equal(Object.keys(written.quaternion).length, 4);
  }
});

test('angles turn about up, then forward, then right', () => {
  for (const [yaw, pitch, roll] of [[0, 0, 0], [90, 0, 0], [0, 30, 0],
    [0, 0, -40], [-130, 55, 170]] as const) {
    const { position, angles } = toBasicYpr(
        geoPoseAnswerOf(answerWith(fromYpr(yaw, pitch, roll))));
    assert.equal(position.h, 523);
    assert.deepEqual(Object.keys(angles), ['yaw', 'pitch', 'roll']);
    for (const [is, wanted] of [[angles.yaw, yaw], [angles.pitch, pitch],
      [angles.roll, roll]] as const) {
      assert.ok(Math.abs(is - wanted) < 1e-9, `${is} is not ${wanted}`);
    }
  }
});

// A phone on its side, whose pictures are not turned.
test('a picture whose right side is straight up keeps its pose', () => {
  for (const pitch of [90, -90]) {
    for (const [yaw, roll] of [[20, 0], [20, 70], [-150, 100]] as const) {
      const quaternion = normalized(fromYpr(yaw, pitch, roll));
      const { angles } = toBasicYpr(geoPoseAnswerOf(answerWith(quaternion)));
      assert.equal(angles.roll, 0);
      assert.ok(Math.abs(angles.yaw) <= 180);
      assert.ok(angleBetweenRad(quaternion,
          fromYpr(angles.yaw, angles.pitch, angles.roll)) < 1e-7);
    }
  }
});
