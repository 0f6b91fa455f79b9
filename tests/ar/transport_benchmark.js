// What a picture's way to the server and back costs in a browser: by calls on a
// kept connection, and over one WebSocket. Run with the environment of ctest:
//   TREELINE_SERVER=build/dev/bin/treeline-server TREELINE_SCENE=... \
//   TREELINE_PAGE=build/ar-page TREELINE_PAGE_WORK=build/ar-page-work \
//   node tests/ar/transport_benchmark.js
// A scene that is not there is refused once the whole picture has arrived and
// has been parsed: what that takes is the way alone.

import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

import { launchWithCamera, open, RECORDING, startServer, telling } from
  './fixture.js';

const COUNT = 200;
const LOCATED = 40;
const WORK = path.resolve(process.env.TREELINE_PAGE_WORK);

const load = (file) => import(pathToFileURL(path.join(WORK, file)).href);
const { create, toBinary } =
  await load('node_modules/@bufbuild/protobuf/dist/esm/index.js');
const { LocalizeRequestSchema, LocalizeStreamRequestSchema } =
  await load('client/dist/gen/treeline/v1/relocalization_pb.js');

const jpeg = fs.readFileSync(
    path.join(RECORDING, 'rgb', `${telling[0]}.jpg`));
const requestOf = (scene) => create(LocalizeRequestSchema, { scene,
  frame: { color: { data: { case: 'encoded', value: jpeg } } } });
const base64 = (schema, message) =>
  Buffer.from(toBinary(schema, message)).toString('base64');

// Runs in the page: times in ms.
async function byCalls({ body, count }) {
  const bytes = Uint8Array.from(atob(body), (c) => c.charCodeAt(0));
  const times = [];
  for (let i = 0; i < count; ++i) {
    const start = performance.now();
    const response = await fetch(
        '/treeline.v1.RelocalizationService/Localize', { method: 'POST', headers:
          { 'Content-Type': 'application/proto',
            'Connect-Protocol-Version': '1' }, body: bytes });
    await response.arrayBuffer();
    times.push(performance.now() - start);
  }
  return times;
}

// `inFlight`: frames on their way at a time; then times are between answers.
async function byStream({ body, count, inFlight }) {
  const bytes = Uint8Array.from(atob(body), (c) => c.charCodeAt(0));
  const socket = new WebSocket(`${location.origin.replace('http', 'ws')}` +
      '/treeline.v1.RelocalizationService/LocalizeStream', ['treeline.v1']);
  socket.binaryType = 'arraybuffer';
  await new Promise((resolve) => { socket.onopen = resolve; });
  const times = [];
  let sent = 0;
  let last = performance.now();
  const send = () => {
    sent += 1;
    socket.send(bytes);
  };
  await new Promise((resolve) => {
    socket.onmessage = () => {
      const now = performance.now();
      times.push(now - last);
      last = now;
      if (times.length === count) resolve();
      else if (sent < count) send();
    };
    for (let i = 0; i < inFlight; ++i) send();
  });
  socket.close();
  return times;
}

const at = (times, share) =>
  [...times].sort((a, b) => a - b)[Math.floor(share * (times.length - 1))];
const figures = (times) => [0.5, 0.95, 1].map((share) =>
  at(times, share).toFixed(1).padStart(8)).join('');

const server = await startServer('--log-level', 'off');
const browser = await launchWithCamera(telling[0]);
const { page } = await open(browser, server.url);
console.log(`${jpeg.length} bytes of JPEG, 640 x 480; ms: median, 95 %, most`);
for (const [what, scene, count] of [['way alone', 'none', COUNT],
  ['located', 'room', LOCATED]]) {
  const call = base64(LocalizeRequestSchema, requestOf(scene));
  const frame = base64(LocalizeStreamRequestSchema, create(
      LocalizeStreamRequestSchema, { id: 1n, localize: requestOf(scene) }));
  // The first ones open connections and load the scene.
  await page.evaluate(byCalls, { body: call, count: 10 });
  for (const [how, run, more] of [['calls', byCalls, {}],
    ['stream', byStream, { inFlight: 1 }],
    ['stream, 2 in flight', byStream, { inFlight: 2 }]]) {
    const times = await page.evaluate(run,
        { body: how === 'calls' ? call : frame, count, ...more });
    console.log(`${what.padEnd(10)} ${how.padEnd(20)}${figures(times)}`);
  }
}
await browser.close();
server.kill();
