import assert from 'node:assert/strict';
import test from 'node:test';

import type { LevelInfo } from '../api/types.js';
import { heightsFromVoxels } from './ground_of_voxels.js';
import { decodeHeights, HeightField } from './height_field.js';

const LEVEL: LevelInfo = { index: 0, width: 4, height: 2, resolution: 0.5,
  origin: [10, 20, 0], minHeight: 0, maxHeight: 1 };
// A slope towards +x; no ground in the last cell.
const SLOPE = new Float32Array([0, 0.5, 1, 1.5, 0, 0.5, 1, NaN]);

function near(actual: number | undefined, wanted: number, by = 0.02): void {
  assert.ok(actual !== undefined && Math.abs(actual - wanted) <= by,
      `${actual} is not ${wanted}`);
}

function bytesOf(width: number, height: number, values: Float32Array) {
  const view = new DataView(new ArrayBuffer(12 + 4 * values.length));
  [...'TLVH'].forEach((c, i) => view.setUint8(i, c.charCodeAt(0)));
  view.setUint32(4, width, true);
  view.setUint32(8, height, true);
  values.forEach((value, i) => view.setFloat32(12 + 4 * i, value, true));
  return view.buffer;
}

test('heights are those of the cells', () => {
  const field = new HeightField(LEVEL, SLOPE);
  assert.equal(field.at(10.1, 20.1), 0);
  assert.equal(field.at(11.9, 20.4), 1.5);
  assert.equal(field.at(11.9, 20.9), null);
  assert.equal(field.at(9.9, 20.1), null);
  assert.equal(field.atOr(9.9, 20.1, 7), 7);
  assert.equal(field.lowest, 0);
  assert.equal(field.highest, 1.5);
});

test('a turned grid is turned', () => {
  const turned: LevelInfo = { ...LEVEL, origin: [10, 20, Math.PI / 2] };
  const field = new HeightField(turned, SLOPE);
  // Its columns go along +y, its rows along -x.
  assert.equal(field.at(9.9, 20.6), 0.5);
  const corner = field.toMap(4, 0);
  near(corner.x, 10, 1e-9);
  near(corner.y, 22, 1e-9);
});

test('a line of sight ends on the slope, not below it', () => {
  const field = new HeightField(LEVEL, SLOPE);
  const hit = field.pick({ x: 11.25, y: 20.25, z: 10 }, { x: 0, y: 0, z: -1 });
  near(hit?.z, 1);
  const aslant = field.pick({ x: 8, y: 20.25, z: 4.25 }, { x: 1, y: 0, z: -1 });
  near(aslant?.x, 11.25, 0.3);
  near(aslant?.z, 1);
});

test('beside the ground it ends on its plane, and above nowhere', () => {
  const field = new HeightField(LEVEL, SLOPE);
  const hit = field.pick({ x: 0, y: 0, z: 10 }, { x: 0, y: 0, z: -1 });
  near(hit?.z, field.typical);
  assert.equal(field.pick({ x: 0, y: 0, z: 10 }, { x: 0, y: 0, z: 1 }), null);
  assert.equal(field.pick({ x: 0, y: 0, z: 10 }, { x: 1, y: 0, z: 0 }), null);
});

test('without heights a level is flat', () => {
  const field = new HeightField({ ...LEVEL, minHeight: 2.5 }, null);
  assert.equal(field.at(11, 20.5), 2.5);
  const hit = field.pick({ x: 11, y: 20.5, z: 9 }, { x: 0, y: 0, z: -1 });
  near(hit?.z, 2.5);
});

test('voxels show a slope, and no table as its ground', () => {
  const level: LevelInfo = { ...LEVEL, width: 3, height: 1, origin: [0, 0, 0],
    minHeight: 0, maxHeight: 0.5 };
  const heights = heightsFromVoxels(level, { resolution: 0.5,
    centres: new Float32Array([
      0.25, 0.25, 0, 0.25, 0.25, 2.5,
      0.75, 0.25, 0, 0.75, 0.25, 0.5, 0.75, 0.25, 2.5,
      1.25, 0.25, 0, 1.25, 0.25, 1,
      9, 9, 0,
    ]) });
  assert.deepEqual([...heights], [0.25, 0.75, NaN]);
});

test('heights are decoded, and refused where they are not the level\'s', () => {
  assert.deepEqual(decodeHeights(bytesOf(4, 2, SLOPE), LEVEL), SLOPE);
  assert.throws(() => decodeHeights(bytesOf(2, 4, SLOPE), LEVEL), /2 x 4/);
  assert.throws(
      () => decodeHeights(bytesOf(4, 2, SLOPE.slice(1)), LEVEL), /40 bytes/);
  assert.throws(() => decodeHeights(new ArrayBuffer(3), LEVEL), /TLVH/);
  assert.throws(() => decodeHeights(new ArrayBuffer(44), LEVEL), /TLVH/);
});
