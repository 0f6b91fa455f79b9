import assert from 'node:assert/strict';
import test from 'node:test';

import { decodeOctomap } from './octomap.js';
import { drawnBelow, meshOf, type Faces } from './voxel_mesh.js';

function bytesOf(count: number, resolution: number, values: number[]) {
  const view = new DataView(new ArrayBuffer(12 + 4 * values.length));
  [...'TLVX'].forEach((c, i) => view.setUint8(i, c.charCodeAt(0)));
  view.setUint32(4, count, true);
  view.setFloat32(8, resolution, true);
  values.forEach((value, i) => view.setFloat32(12 + 4 * i, value, true));
  return view.buffer;
}

const mapOf = (...voxels: number[][]) =>
  ({ resolution: 1, centres: new Float32Array(voxels.flat()) });

// Area of all rectangles, whose normals are axes.
function area({ positions, rectangles }: Faces): number {
  let sum = 0;
  for (let i = 0; i < rectangles; ++i) {
    const corner = (k: number) => positions.subarray(12 * i + 3 * k);
    const [a, b, d] = [corner(0), corner(1), corner(3)];
    const side = (p: Float32Array, q: Float32Array) =>
      Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
    sum += side(a, b) * side(a, d);
  }
  return sum;
}

test('an OctoMap is decoded', () => {
  const map = decodeOctomap(bytesOf(2, 0.5, [1, 2, 3, 4, 5, 6]));
  assert.equal(map.resolution, 0.5);
  assert.deepEqual([...map.centres], [1, 2, 3, 4, 5, 6]);
});

test('what is no OctoMap is refused', () => {
  assert.throws(() => decodeOctomap(new ArrayBuffer(4)), /TLVX/);
  assert.throws(() => decodeOctomap(bytesOf(3, 0.5, [1, 2, 3])), /3 voxels/);
  assert.throws(() => decodeOctomap(bytesOf(1, 0, [1, 2, 3])), /resolution/);
});

test('one voxel has five faces that are seen', () => {
  const mesh = meshOf(mapOf([5, 5, 5]));
  assert.equal(mesh.body.rectangles, 5);
  assert.equal(mesh.caps.rectangles, 0);
  const { positions } = mesh.body;
  assert.equal(Math.min(...positions), 4.5);
  assert.equal(Math.max(...positions), 5.5);
});

test('faces of a row are one, and none is between neighbours', () => {
  const mesh = meshOf(mapOf([0, 0, 0], [1, 0, 0], [2, 0, 0]));
  assert.equal(mesh.body.rectangles, 5);
  assert.equal(area(mesh.body), 3 + 3 + 3 + 1 + 1);
});

test('faces look outwards', () => {
  const { body } = meshOf(mapOf([0, 0, 0]));
  for (let i = 0; i < body.rectangles; ++i) {
    const p = body.positions.subarray(12 * i, 12 * i + 12);
    const u = [p[3] - p[0], p[4] - p[1], p[5] - p[2]];
    const v = [p[9] - p[0], p[10] - p[1], p[11] - p[2]];
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
      u[0] * v[1] - u[1] * v[0]];
    const outwards = normal[0] * (p[0] + p[6]) + normal[1] * (p[1] + p[7]) +
        normal[2] * (p[2] + p[8]);
    assert.ok(outwards > 0, `face ${i}`);
  }
});

test('the five sides of a voxel are lit differently, its top the most', () => {
  const { body } = meshOf(mapOf([0, 0, 0]));
  const light = Array.from({ length: 5 }, (_, i) =>
    body.colours.subarray(12 * i, 12 * i + 3).reduce((a, b) => a + b, 0));
  assert.equal(new Set(light).size, 5);
  // The faces' heights: the top alone is level.
  const top = light.findIndex((_, i) => [2, 5, 8, 11].every(
      (z) => body.positions[12 * i + z] === 0.5));
  assert.equal(light[top], Math.max(...light));
});

test('a cut draws what is below and closes it', () => {
  const mesh = meshOf(mapOf([0, 0, 0.5], [0, 0, 1.5], [0, 0, 2.5]));
  assert.equal(mesh.bottom, 0);
  assert.deepEqual(drawnBelow(mesh, Infinity), { body: 13, caps: [0, 0] });
  assert.deepEqual(drawnBelow(mesh, 2), { body: 8, caps: [1, 2] });
  assert.deepEqual(drawnBelow(mesh, 1), { body: 4, caps: [0, 1] });
  assert.deepEqual(drawnBelow(mesh, -1), { body: 0, caps: [0, 0] });
});

test('an empty OctoMap has no faces, a huge one is refused', () => {
  assert.equal(meshOf(mapOf()).body.rectangles, 0);
  assert.throws(
      () => meshOf(mapOf([0, 0, 0], [1e4, 1e4, 1e4])), /too large/);
});
