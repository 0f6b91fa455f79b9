import assert from 'node:assert/strict';
import test from 'node:test';

import { Code, ConnectError } from '@connectrpc/connect';

import { SceneService, type GetSceneMapRequest } from
  '../gen/treeline/v1/scenes_pb.js';
import { serve } from '../testing/fake_server.js';
import { TreelineError } from './error.js';
import { TreelineClient } from './treeline_client.js';

const floats = (...values: number[]) =>
  new Uint8Array(new Float32Array(values).buffer);
const POSE = { rotation: { w: 1 }, translationM: { x: 1, y: 2, z: 3 } };
const COVERAGE = { columns: 2, rows: 1, headings: 16, cellM: 0.25,
  isOpen: new Uint8Array([1, 0]), goodHeadings: new Uint8Array([16, 0]),
  weakHeadings: new Uint8Array([0, 0]), openM2: 0.0625 };

const serverOf = (map: object, asked: GetSceneMapRequest[] = []) =>
  serve((router) => router.service(SceneService, {
    getSceneMap: (request) => {
      asked.push(request);
      return { scene: 'hall', modelVersion: '3', ...map };
    },
    listRecentQueries: ({ scene }) => {
      if (scene !== 'hall') {
        throw new ConnectError('keeps none', Code.FailedPrecondition);
      }
      return { queries: [
        { timeUtc: '2025-11-21T09:30:00.250Z', worldFromCamera: POSE,
          inliers: 40 },
        { timeUtc: '2025-11-21T09:29:00.250Z', reason: 'TOO_FEW_INLIERS' },
      ] };
    },
  }));

test('a map has points, keyframes and coverage', async (context) => {
  const asked: GetSceneMapRequest[] = [];
  const server = await serverOf({
    // Not at a multiple of four bytes.
    pointsInWorldM: new Uint8Array([9, ...floats(1.5, 2, -3)]).subarray(1),
    brightness: new Uint8Array([7]), pointsInModel: 1000n,
    worldFromKeyframe: [POSE], planFromWorld: { w: 0, x: 1 },
    camera: { model: 'PINHOLE', widthPx: 640, heightPx: 480,
      parameters: [525, 525, 319.5, 239.5] }, coverage: COVERAGE }, asked);
  context.after(() => server.close());
  const client = new TreelineClient({ servers: server.url });
  const map = await client.sceneMap('hall',
      { maxPoints: 10, wantsCoverage: true });
  assert.equal(asked[0]!.maxPoints, 10);
  assert.ok(asked[0]!.includeCoverage);
  assert.deepEqual([...map.pointsInWorldM], [1.5, 2, -3]);
  assert.deepEqual([...map.brightness], [7]);
  assert.equal(map.pointsInModel, 1000);
  assert.deepEqual(map.worldFromKeyframe[0]!.translationM,
      { x: 1, y: 2, z: 3 });
  assert.equal(map.planFromWorld.x, 1);
  assert.equal(map.camera?.widthPx, 640);
  assert.deepEqual([...map.coverage!.goodHeadings], [16, 0]);
  assert.equal(map.coverage!.openM2, 0.0625);
});

test('a map that contradicts itself is refused', async () => {
  for (const map of [
    { pointsInWorldM: floats(1, 2, 3), brightness: new Uint8Array() },
    { coverage: { ...COVERAGE, isOpen: new Uint8Array(3) } },
  ]) {
    const server = await serverOf(map);
    await assert.rejects(
        new TreelineClient({ servers: server.url }).sceneMap('hall'),
        (error) => error instanceof TreelineError && error.code === 'internal');
    await server.close();
  }
});

test('the latest queries say where, or why not', async (context) => {
  const server = await serverOf({});
  context.after(() => server.close());
  const client = new TreelineClient({ servers: server.url });
  const [first, second] = await client.recentQueries('hall');
  assert.deepEqual(first!.worldFromCamera?.translationM, { x: 1, y: 2, z: 3 });
  assert.equal(first!.inliers, 40);
  assert.equal(second!.worldFromCamera, null);
  assert.equal(second!.reason, 'TOO_FEW_INLIERS');
  await assert.rejects(client.recentQueries('attic'), (error) =>
    error instanceof TreelineError && error.code === 'failed_precondition');
});
