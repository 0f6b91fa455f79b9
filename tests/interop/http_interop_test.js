// What the HTTP gateway is to others: the npm package @oarc/gpp-access, and
// fetch as browsers have it. Run by ctest:
//   node --import ./bundler_resolution.js --test http_interop_test.js
// with TREELINE_INTEROP_SERVER naming the program of interop_server.cc.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { createInterface } from 'node:readline';
import { after, before, test } from 'node:test';

import {
  CAMERAMODEL, CameraParam, GeoPoseRequest, IMAGEFORMAT, ImageOrientation,
  Privacy, SENSORTYPE, Sensor, sendRequest,
} from '@oarc/gpp-access';

import { askGeoPose, assertValidAnswer } from './geo_pose_schema.js';

const PAGE = 'https://app.example.com';
const LOCALIZE = '/treeline.v1.RelocalizationService/Localize';
// First bytes of a JPEG: the service behind looks no further.
const PICTURE = Buffer.from([0xff, 0xd8, 0xff, 0xe0, 0, 0, 0, 0])
  .toString('base64');

let server;
let url;

before(async () => {
  server = spawn(process.env.TREELINE_INTEROP_SERVER, [PAGE],
    { stdio: ['pipe', 'pipe', 'inherit'] });
  for await (const line of createInterface({ input: server.stdout })) {
    const match = /^listening on (.*)$/.exec(line);
    if (match) {
      url = `http://${match[1]}`;
      return;
    }
  }
  throw new Error('the server ended');
});

after(() => server.stdin.end());

function post(path, body, headers = {}, options = {}) {
  return fetch(url + path, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json', ...headers },
    body,
    ...options,
  });
}

function geoPoseRequest(focalLength, rotation = 0) {
  const params = new CameraParam();
  params.model = CAMERAMODEL.PINHOLE;
  params.modelParams = [focalLength, focalLength, 320, 240];
  const privacy = new Privacy();
  return new GeoPoseRequest('request-1')
    .addSensor(new Sensor('camera', SENSORTYPE.camera))
    .addSensor(new Sensor('gps', SENSORTYPE.geolocation))
    .addCameraData(IMAGEFORMAT.JPG, [640, 480], PICTURE, 0,
      new ImageOrientation(false, rotation), params, 1764000000123, 'camera', privacy)
    .addGeoLocationData(48.1371, 11.5751, 520, 20, 20, 0, 0, 1764000000123,
      'gps', privacy);
}

test('@oarc/gpp-access gets a GeoPose', async () => {
  const answer = await askGeoPose(`${url}/geopose`, geoPoseRequest(585));
  assert.equal(answer.id, 'request-1');
  assert.equal(answer.type, 'geopose');
  assert.equal(answer.timestamp, 1764000000123);
  // 1 m east, 2 m north and 3 m up of the anchor.
  const { position, quaternion } = answer.geopose;
  assert.ok(Math.abs(position.h - 523) < 1e-3);
  assert.ok(Math.abs((position.lat - 48.137) * 111200 - 2) < 0.01);
  assert.ok(Math.abs((position.lon - 11.575) * 74400 - 1) < 0.01);
  // The camera looks up, with the top of the picture to the south: a quarter
  // turn about the axis to its right.
  const norm = Math.hypot(...Object.values(quaternion));
  assert.ok(Math.abs(norm - 1) < 1e-9);
  assert.ok(Math.abs(Math.abs(quaternion.x) - Math.SQRT1_2) < 1e-5);
  assert.ok(Math.abs(quaternion.w - Math.SQRT1_2) < 1e-5);
  assert.ok(answer.accuracy.position > 0 && answer.accuracy.position < 0.1);
  assert.ok(answer.accuracy.orientation > 0);
});

test('an answer with less, more or other than a GeoPose is none', async () => {
  const answer = await askGeoPose(`${url}/geopose`, geoPoseRequest(585));
  const { position } = answer.geopose;
  for (const wrong of [{ ...answer, more: 1 }, { ...answer, id: 1 },
    { ...answer, geopose: { position } },
    { ...answer, geopose: { ...answer.geopose,
      position: { ...position, lat: 91 } } }]) {
    assert.throws(() => assertValidAnswer(wrong));
  }
});

test('@oarc/gpp-access sends a picture that lies on its side', async () => {
  const answer = await askGeoPose(`${url}/geopose`, geoPoseRequest(585, 90));
  assert.ok(Math.abs(answer.geopose.position.h - 524) < 1e-3);
});

test('@oarc/gpp-access learns that there is no pose', async () => {
  await assert.rejects(
    sendRequest(`${url}/geopose`, JSON.stringify(geoPoseRequest(100))),
    /not localized.*|TOO_FEW_INLIERS/);
});

test('@oarc/gpp-access learns that no scene is near', async () => {
  const request = JSON.parse(JSON.stringify(geoPoseRequest(585)));
  request.sensorReadings.geoLocationReadings[0].latitude = -30;
  await assert.rejects(sendRequest(`${url}/geopose`, JSON.stringify(request)),
    /NO_SCENE_NEAR/);
});

test('GET /geopose answers a status', async () => {
  const response = await fetch(`${url}/geopose`);
  assert.deepEqual(await response.json(), { status: 'running' });
});

test('fetch says which way up a picture is', async () => {
  const response = await post(LOCALIZE, JSON.stringify({
    scene: 'hall',
    frame: {
      color: { encoded: PICTURE },
      camera: {
        model: 'PINHOLE', widthPx: 640, heightPx: 480,
        parameters: [585, 585, 319.5, 239.5],
      },
      orientation: 'ORIENTATION_LEFT_UP',
      gravityInCameraMps2: { x: 9.81 },
    },
    options: {
      positionPrior: { positionInWorldM: { x: 1, y: 2, z: 3 }, radiusM: 5 },
      heightBand: { minM: 0, maxM: 10 },
    },
  }));
  const answer = await response.json();
  assert.equal(response.status, 200, JSON.stringify(answer));
  assert.equal(answer.worldFromCamera.translationM.z, 4);
});

test('fetch calls with JSON', async () => {
  const response = await post(LOCALIZE, JSON.stringify({
    scene: 'hall',
    frame: {
      color: { encoded: PICTURE },
      camera: {
        model: 'PINHOLE', widthPx: 640, heightPx: 480,
        parameters: [585, 585, 319.5, 239.5],
      },
    },
  }), { 'Connect-Protocol-Version': '1' });
  assert.equal(response.status, 200);
  assert.equal(response.headers.get('content-type'), 'application/json');
  const answer = await response.json();
  assert.equal(answer.outcome, 'OUTCOME_LOCALIZED');
  assert.equal(answer.inliers, 400);
  assert.deepEqual(answer.worldFromCamera.translationM, { x: 1, y: 2, z: 3 });
  assert.equal(answer.covariance.length, 36);
});

test('fetch calls with binary messages', async () => {
  const name = new TextEncoder().encode('kitchen');
  // Field 1, a string.
  const request = new Uint8Array([0x0a, name.length, ...name]);
  const response = await post('/treeline.v1.SceneService/GetScene', request,
    { 'Content-Type': 'application/proto' });
  assert.equal(response.status, 200);
  assert.equal(response.headers.get('content-type'), 'application/proto');
  // GetSceneResponse.scene.scene: both are field 1.
  assert.deepEqual(new Uint8Array(await response.arrayBuffer()),
    new Uint8Array([0x0a, name.length + 2, 0x0a, name.length, ...name]));
});

test('fetch reads errors of the Connect protocol', async () => {
  const response = await post(LOCALIZE, '{"scene":"nowhere"}');
  assert.equal(response.status, 404);
  assert.equal(response.headers.get('retry-after'), '3');
  const error = await response.json();
  assert.equal(error.code, 'not_found');
  assert.equal(error.details[0].type, 'google.rpc.ErrorInfo');
  assert.equal(error.details[0].debug.reason, 'SCENE_NOT_FOUND');
  assert.match(Buffer.from(error.details[0].value, 'base64').toString(),
    /SCENE_NOT_FOUND/);
  const unknown = await post(LOCALIZE, '{"scence":"hall"}');
  assert.equal(unknown.status, 400);
  assert.match((await unknown.json()).message, /scence/);
});

test('a preflight lets an allowed page in, and no other', async () => {
  const preflight = (origin) => fetch(url + LOCALIZE, {
    method: 'OPTIONS',
    headers: {
      Origin: origin,
      'Access-Control-Request-Method': 'POST',
      'Access-Control-Request-Headers': 'content-type',
    },
  });
  const allowed = await preflight(PAGE);
  assert.equal(allowed.status, 204);
  assert.equal(allowed.headers.get('access-control-allow-origin'), PAGE);
  assert.match(allowed.headers.get('access-control-allow-headers'),
    /content-type/i);
  const refused = await preflight('https://evil.example.com');
  assert.equal(refused.status, 403);
  assert.equal(refused.headers.get('access-control-allow-origin'), null);
});

test('a deadline ends a call', async () => {
  const response = await post(LOCALIZE, '{"scene":"slow"}',
    { 'Connect-Timeout-Ms': '20' });
  assert.equal(response.status, 504);
  assert.equal((await response.json()).code, 'deadline_exceeded');
});

test('a client that goes stops its call', { timeout: 60000 }, async () => {
  const stopped = async () => {
    const text = await (await fetch(`${url}/metrics`)).text();
    return Number(/stopped (\d+)/.exec(text)[1]);
  };
  const earlier = await stopped();
  await assert.rejects(post(LOCALIZE, '{"scene":"slow"}', {},
    { signal: AbortSignal.timeout(50) }));
  // Ends with the test's time-out if the call goes on.
  while (await stopped() === earlier);
});
