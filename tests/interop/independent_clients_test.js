// treeline-server asked by clients that know nothing of Treeline, as they come
// from npm: @connectrpc/connect-node, @connectrpc/connect-web, buf curl and
// @grpc/grpc-js. None has generated code: they learn the contract from
// contract.binpb or from the server's reflection. Run by ctest; environment as
// served_scenes.js, and INTEROP_CONTRACT, the file contract.binpb.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { promisify } from 'node:util';

import { createFileRegistry, fromBinary } from '@bufbuild/protobuf';
import { FileDescriptorSetSchema } from '@bufbuild/protobuf/wkt';
import { ConnectError, createClient } from '@connectrpc/connect';
import * as connectNode from '@connectrpc/connect-node';
import * as connectWeb from '@connectrpc/connect-web';
import grpc from '@grpc/grpc-js';
import reflection from 'grpc-js-reflection-client';

import { frameFile, serveScenes, truePose } from './served_scenes.js';

const SERVICE = 'treeline.v1.RelocalizationService';
// Of a camera 2.5 cm beside it; 5 cm is what counts as right.
const NEAR_M = 0.05;
const REGISTRATION = 'DEPTH_REGISTRATION_SCENE_CALIBRATION';

let server;
before(async () => { server = await serveScenes(); });
after(() => server?.stop());

const contract = createFileRegistry(fromBinary(FileDescriptorSetSchema,
    readFileSync(process.env.INTEROP_CONTRACT)));
const service = contract.getService(SERVICE);
// As connectrpc has it: by number.
const REGISTRATION_NUMBER = contract.getEnum('treeline.v1.DepthRegistration')
    .values.find(({ name }) => name === REGISTRATION).number;

// A frame with depth, whose enumeration is named or numbered as a client has it.
const frameOf = (bytesOf, registration) => ({
  color: { encoded: bytesOf(frameFile('color.jpg')) },
  depth: { png: bytesOf(frameFile('depth.png')), unitM: 0.001, registration },
});

function assertNear({ x, y, z }) {
  const awayM =
      Math.hypot(x - truePose[3], y - truePose[7], z - truePose[11]);
  assert.ok(awayM < NEAR_M, `${awayM} m from the truth`);
}

// Clients of connectrpc, by transport.
const TRANSPORTS = {
  'connect-node, Connect over HTTP/1.1': () =>
    connectNode.createConnectTransport(
        { baseUrl: server.url, httpVersion: '1.1' }),
  'connect-node, Connect in JSON': () => connectNode.createConnectTransport(
      { baseUrl: server.url, httpVersion: '1.1', useBinaryFormat: false }),
  'connect-node, gRPC': () => connectNode.createGrpcTransport(
      { baseUrl: `http://${server.grpc}` }),
  'connect-web, binary': () => connectWeb.createConnectTransport(
      { baseUrl: server.url, useBinaryFormat: true }),
  'connect-web, JSON': () =>
    connectWeb.createConnectTransport({ baseUrl: server.url }),
};

for (const [name, transportOf] of Object.entries(TRANSPORTS)) {
  test(`${name} is told where a frame was taken, and why not`, async () => {
    const transport = transportOf();
    const client = createClient(service, transport);
    const { depth: { png, ...rest }, color: { encoded } } =
        frameOf((bytes) => new Uint8Array(bytes),
            REGISTRATION_NUMBER);
    const answer = await client.localize({ scene: 'room', frame: {
      color: { data: { case: 'encoded', value: encoded } },
      depth: { data: { case: 'png', value: png }, ...rest } } });
    assertNear(answer.worldFromCamera.translationM);
    await assert.rejects(client.localize({ scene: 'attic', frame: {} }),
        (error) => {
          assert.ok(error instanceof ConnectError);
          assert.match(error.message, /not_found.*attic/);
          return true;
        });
    const { scenes } = await createClient(
        contract.getService('treeline.v1.SceneService'), transport)
        .listScenes({});
    assert.deepEqual(scenes.map(({ scene }) => scene).sort(),
        ['hall', 'room']);
  });
}

test('@grpc/grpc-js learns the contract by reflection, and localizes',
    async () => {
      const asked = new reflection.GrpcReflection(server.grpc,
          grpc.credentials.createInsecure());
      assert.ok((await asked.listServices()).includes(SERVICE));
      const descriptor = await asked.getDescriptorBySymbol(SERVICE);
      const { treeline } = descriptor.getPackageObject({ enums: String });
      const client = new treeline.v1.RelocalizationService(server.grpc,
          grpc.credentials.createInsecure());
      const call = (request) => new Promise((resolve, reject) =>
        client.Localize(request,
            (error, answer) => (error ? reject(error) : resolve(answer))));
      // Names as the contract spells them.
      const { color, depth: { unitM, ...depth } } =
          frameOf((bytes) => bytes, REGISTRATION);
      const answer = await call({ scene: 'room',
        frame: { color, depth: { unit_m: unitM, ...depth } } });
      assert.equal(answer.outcome, 'OUTCOME_LOCALIZED');
      assertNear(answer.world_from_camera.translation_m);
      await assert.rejects(call({ scene: 'attic' }),
          ({ code }) => code === grpc.status.NOT_FOUND);
      client.close();
    });

test('buf curl learns the contract by reflection, and localizes', async () => {
  const request = JSON.stringify({ scene: 'room',
    frame: frameOf((bytes) => bytes.toString('base64'), REGISTRATION) });
  const curl = (body, ...flags) => {
    const done = promisify(execFile)('node_modules/.bin/buf',
        ['curl', ...flags, '--data', '@-'], { maxBuffer: 1 << 24 });
    done.child.stdin.end(body);
    return done;
  };
  const overGrpc = ['--protocol', 'grpc', '--http2-prior-knowledge',
    `http://${server.grpc}/${SERVICE}/Localize`];
  // Reflection is gRPC's; over Connect the contract is given.
  const overConnect = ['--schema', process.env.INTEROP_CONTRACT,
    `${server.url}/${SERVICE}/Localize`];
  for (const flags of [overGrpc, overConnect]) {
    const { stdout } = await curl(request, ...flags);
    const answer = JSON.parse(stdout);
    assert.equal(answer.outcome, 'OUTCOME_LOCALIZED');
    assertNear(answer.worldFromCamera.translationM);
    await assert.rejects(curl('{"scene": "attic", "frame": {}}', ...flags),
        ({ stderr }) => /not_found/.test(stderr));
  }
});
