// @treeline/client, as it is packed, against treeline-server with a scene that
// it has learned: the same answers as treeline-client's. Run by ctest
// (run_test.cmake) with TREELINE_SERVER, TREELINE_CLIENT and TREELINE_SCENE (a
// folder with recording/ and room.treeline, of
// tests/integration/make_scene.cmake).
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { copyFileSync, cpSync, mkdirSync, readFileSync, writeFileSync } from
  'node:fs';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { after, before, test } from 'node:test';

import { install } from './installed.js';

const { TREELINE_CLIENT, TREELINE_ROOT, TREELINE_SCENE, TREELINE_SERVER } =
  process.env;
const RECORDING = join(TREELINE_SCENE, 'recording');
const ANCHOR = { latitude_deg: 48.137, longitude_deg: 11.575, height_m: 520,
  enu_from_world: { w: 1, x: 0, y: 0, z: 0 } };

const installed = install();
const { DriftCorrector, FrameQueue, TreelineClient, TreelineError, fixOf,
  inverse, compose, fromColumnMajor4 } = await installed.load('index.js');
const { connectWithTls } = await installed.load('node.js');
const servers = [];
const stems = readFileSync(join(RECORDING, 'test.txt'), 'utf8').trim()
  .split(/\s+/);
let plain;

// Starts treeline-server; its addresses.
async function start(...flags) {
  const server = spawn(TREELINE_SERVER, ['--models',
    join(installed.root, 'models'), '--listen', '127.0.0.1:0',
    '--admin-listen', '', '--http-listen', '127.0.0.1:0', '--drain-s', '0',
    ...flags], { stdio: ['ignore', 'pipe', 'inherit'] });
  servers.push(server);
  let grpc;
  for await (const line of createInterface({ input: server.stdout })) {
    const match = /^(listening|http) on (.*)$/.exec(line);
    if (match?.[1] === 'listening') grpc = match[2];
    if (match?.[1] === 'http') return { grpc, http: match[2], server };
  }
  throw new Error('the server ended');
}

const fileOf = (stem, kind) => join(RECORDING, `${stem}.${kind}`);

const queryOf = (stem) => ({
  scene: 'room',
  color: readFileSync(fileOf(stem, 'color.jpg')),
  depth: { image: readFileSync(fileOf(stem, 'depth.png')), unitM: 0.001,
    registration: 'scene_calibration' },
});

// What treeline-client says of a frame.
function answerOfCpp(stem, ...flags) {
  try {
    return JSON.parse(execFileSync(TREELINE_CLIENT, ['localize', '--server',
      plain.grpc, '--scene', 'room', '--color', fileOf(stem, 'color.jpg'),
      '--depth', fileOf(stem, 'depth.png'), '--json', ...flags],
    { encoding: 'utf8' }));
  } catch (error) {
    // 3: not localized.
    if (error.status !== 3) throw error;
    return JSON.parse(error.stdout);
  }
}

// worldFromCamera of the recording; 7-Scenes has rows.
function truthOf(stem) {
  const rows = readFileSync(fileOf(stem, 'pose.txt'), 'utf8').trim()
    .split(/\s+/).map(Number);
  return fromColumnMajor4(rows.map((_, i) => rows[(i % 4) * 4 + (i >> 2)]));
}

const distance = (a, b) => Math.hypot(a.x - b.x, a.y - b.y, a.z - b.z);

before(async () => {
  const version = join(installed.root, 'models', 'room', '1');
  mkdirSync(version, { recursive: true });
  cpSync(join(TREELINE_SCENE, 'room.treeline'), join(version, 'model.treeline'));
  writeFileSync(join(installed.root, 'models', 'room', 'scene.json'),
    JSON.stringify({ display_name: 'Room', geo_anchor: ANCHOR }));
  plain = await start();
  plain.url = `http://${plain.http}`;
});

after(() => {
  for (const server of servers) server.kill('SIGTERM');
  installed.remove();
});

test('answers are those of treeline-client, bit for bit', async () => {
  const client = new TreelineClient({ servers: plain.url });
  let localized = 0;
  for (const stem of stems.slice(0, 5)) {
    const ours = await client.localize(queryOf(stem));
    const theirs = answerOfCpp(stem);
    assert.equal(ours.localized, theirs.outcome === 'LOCALIZED', stem);
    assert.equal(ours.inliers, theirs.inliers);
    assert.equal(ours.samples, theirs.samples);
    assert.equal(ours.inlierRatio, theirs.inlier_ratio);
    assert.equal(ours.confidence, theirs.confidence);
    assert.equal(ours.confidenceThreshold, theirs.confidence_threshold);
    assert.equal(ours.scene, theirs.scene);
    assert.equal(ours.modelVersion, theirs.version);
    if (!ours.localized) {
      assert.equal(ours.reason, theirs.reason);
      continue;
    }
    localized += 1;
    const { rotation: q, translationM: t } = ours.worldFromCamera;
    assert.deepEqual({ qw: q.w, qx: q.x, qy: q.y, qz: q.z, tx: t.x, ty: t.y,
      tz: t.z }, theirs.world_from_camera);
    assert.deepEqual(ours.covariance, theirs.covariance);
    assert.equal(ours.poseSensor, theirs.pose_sensor.toLowerCase());
    assert.ok(distance(t, truthOf(stem).translationM) < 0.05, stem);
  }
  assert.ok(localized >= 3, `${localized} of 5`);
});

test('options reach the server: a prior elsewhere refuses the pose',
  async () => {
    const client = new TreelineClient({ servers: plain.url });
    const ours = await client.localize({ ...queryOf(stems[0]), positionPrior: {
      positionInWorldM: { x: 50, y: 0, z: 0 }, radiusM: 1 } });
    assert.ok(!ours.localized);
    assert.equal(ours.reason, answerOfCpp(stems[0], '--near', '50,0,0,1').reason);
    assert.equal(ours.reason, 'CONTRADICTS_PRIOR');
  });

test('the scene is found, and its picture\'s support is told', async () => {
  const client = new TreelineClient({ servers: plain.url });
  const { scene, ...anywhere } = queryOf(stems[0]);
  const answer = await client.localize(
    { ...anywhere, wantsCorrespondences: true });
  assert.equal(answer.scene, scene);
  assert.equal(answer.candidates[0].scene, scene);
  assert.equal(answer.correspondences.filter(({ inlier }) => inlier).length,
    answer.inliers);
});

test('scenes, health and errors are the server\'s own', async () => {
  const client = new TreelineClient({ servers: plain.url });
  const [room] = await client.scenes();
  assert.equal(room.name, 'room');
  assert.equal(room.state, 'ready');
  assert.equal(room.displayName, 'Room');
  assert.equal(room.method, 'rgbd');
  assert.equal(room.geoAnchor.latitudeDeg, ANCHOR.latitude_deg);
  assert.equal(room.camera.model, 'PINHOLE');
  assert.deepEqual(await client.scene('room'), room);
  const [health] = await client.health();
  assert.equal(health.ready, true);
  await assert.rejects(client.localize({ ...queryOf(stems[0]), scene: 'attic' }),
    (error) => error instanceof TreelineError && error.code === 'not_found' &&
      error.reason === 'SCENE_NOT_FOUND');
  await assert.rejects(
    client.localize({ scene: 'room', color: new Uint8Array([1, 2]) }),
    (error) => error.code === 'invalid_argument' &&
      error.reason === 'INVALID_REQUEST');
  await assert.rejects(client.localize(queryOf(stems[0]), { timeoutMs: 1 }),
    (error) => error.code === 'deadline_exceeded');
});

test('a frame without a pose has no GeoPose, and says why', async () => {
  const client = new TreelineClient({ servers: plain.url });
  // The scene answers with depth only, which this query does not bring.
  await assert.rejects(client.geoPose({ captureTimeMs: 1764000000000,
    color: readFileSync(fileOf(stems[0], 'color.jpg')), widthPx: 640,
    heightPx: 480, geolocation: { latitudeDeg: ANCHOR.latitude_deg,
      longitudeDeg: ANCHOR.longitude_deg, altitudeM: 520, accuracyM: 20 } }),
  (error) => error instanceof TreelineError && error.reason !== '' &&
    error.code !== 'internal' && error.code !== 'unknown');
  await assert.rejects(client.geoPose({ captureTimeMs: 1764000000000,
    color: readFileSync(fileOf(stems[0], 'color.jpg')), widthPx: 640,
    heightPx: 480, geolocation: { latitudeDeg: ANCHOR.latitude_deg + 1,
      longitudeDeg: ANCHOR.longitude_deg, altitudeM: 520, accuracyM: 20 } }),
  (error) => error.reason === 'NO_SCENE_NEAR');
});

test('a recording in a frame of its own comes back to the world', async () => {
  const client = new TreelineClient({ servers: plain.url });
  const corrector = new DriftCorrector({ maxGapS: 10, maxSpeedMps: 100,
    maxTurnDegps: 7200 });
  const queue = new FrameQueue();
  const answers = client.localizeLatest(queue, { maxInFlight: 2 });
  const worldFromDevice = { rotation: { w: 0.6, x: 0, y: 0, z: 0.8 },
    translationM: { x: 4, y: -3, z: 1 } };
  let last;
  for (const [i, stem] of stems.slice(0, 6).entries()) {
    const timeMs = 1000 * (i + 1);
    last = corrector.track(
      timeMs, compose(inverse(worldFromDevice), truthOf(stem)));
    queue.push(timeMs, queryOf(stem));
    const { value } = await answers.next();
    assert.equal(value.captureTimeMs, timeMs);
    const fix = value.answer && fixOf(value.answer, value.captureTimeMs);
    if (fix) corrector.addFix(fix);
  }
  queue.end();
  assert.ok((await answers.next()).done);
  assert.equal(last.state, 'locked');
  assert.ok(distance(last.worldFromCamera.translationM,
    truthOf(stems[5]).translationM) < 0.05);
});

test('a replica takes over from a server that ends',
  async () => {
    const gone = await start();
    const both = new TreelineClient(
      { servers: [`http://${gone.http}`, plain.url] });
    assert.ok((await both.localize(queryOf(stems[0]))).scene === 'room');
    await new Promise((resolve) => {
      gone.server.once('exit', resolve);
      gone.server.kill('SIGTERM');
    });
    assert.ok((await both.localize(queryOf(stems[0]))).scene === 'room');
    assert.deepEqual((await both.health()).map(({ ready }) => ready),
      [false, true]);
  });

test('TLS and tokens', async (t) => {
  const folder = join(installed.root, 'keys');
  mkdirSync(join(folder, 'public'), { recursive: true });
  const file = (name) => join(folder, name);
  const openssl = (...words) =>
    execFileSync('openssl', words, { stdio: 'pipe' });
  try {
    openssl('req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '1',
      '-subj', '/CN=localhost', '-addext',
      'subjectAltName=DNS:localhost,IP:127.0.0.1', '-keyout', file('tls.key'),
      '-out', file('tls.pem'));
  } catch (error) {
    if (error.code !== 'ENOENT') throw error;
    t.skip('no openssl on this machine');
    return;
  }
  openssl('genrsa', '-out', file('token.key'), '2048');
  openssl('rsa', '-in', file('token.key'), '-pubout', '-out',
    join(folder, 'public', 'dev.pem'));
  const { http } = await start('--tls-cert', file('tls.pem'), '--tls-key',
    file('tls.key'), '--auth-keys', join(folder, 'public'));
  const url = `https://${http}`;
  const token = execFileSync(join(TREELINE_ROOT, 'scripts', 'make-dev-token'),
    [file('token.key'), 'dev', 'phone', 'localize'],
    { encoding: 'utf8' }).trim();
  const tls = { caFile: file('tls.pem') };
  const client = connectWithTls(
    { servers: url, tls, token: async () => token });
  assert.equal((await client.localize(queryOf(stems[0]))).scene, 'room');
  assert.equal((await client.health())[0].ready, true);
  await assert.rejects(
    connectWithTls({ servers: url, tls }).localize(queryOf(stems[0])),
    (error) => error.code === 'unauthenticated' &&
      error.reason === 'TOKEN_MISSING');
  await assert.rejects(
    connectWithTls({ servers: url, tls, token: 'forged' })
      .localize(queryOf(stems[0])),
    (error) => error.code === 'unauthenticated' &&
      error.reason === 'TOKEN_INVALID');
  // Node itself does not trust this certificate.
  await assert.rejects(new TreelineClient({ servers: url, token,
    retry: { maxAttempts: 1 } }).localize(queryOf(stems[0])),
  (error) => error.code === 'unavailable');
});
