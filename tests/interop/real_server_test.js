// treeline-server itself, with scenes it has learned, asked by clients that are
// not ours: the npm package @oarc/gpp-access, and fetch as browsers have it.
// Run by ctest:
//   node --import ./bundler_resolution.js --test real_server_test.js
// with INTEROP_SERVER, INTEROP_TRAINER and INTEROP_SCENE (a folder
// with recording/ and room.treeline, of tests/integration/make_scene.cmake).
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import {
  CAMERAMODEL, CameraParam, GeoPoseRequest, IMAGEFORMAT, ImageOrientation,
  Privacy, SENSORTYPE, Sensor,
} from '@oarc/gpp-access';

import { askGeoPose } from './geo_pose_schema.js';
import { ANCHOR, frameFile, serveScenes, truePose as pose } from
  './served_scenes.js';

const LOCALIZE = '/treeline.v1.RelocalizationService/Localize';
// A degree at 48 degrees north (m).
const NORTH_M = 111200;
const EAST_M = 74430;

let server;
let url;
before(async () => {
  server = await serveScenes();
  ({ url } = server);
});
after(() => server?.stop());

const base64Of = (kind) => frameFile(kind).toString('base64');

test('fetch is told where a frame with depth was taken', async () => {
  const response = await fetch(url + LOCALIZE, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify({
      scene: 'room',
      frame: {
        color: { encoded: base64Of('color.jpg') },
        depth: {
          png: base64Of('depth.png'),
          unitM: 0.001,
          registration: 'DEPTH_REGISTRATION_SCENE_CALIBRATION',
        },
      },
    }),
  });
  const answer = await response.json();
  assert.equal(response.status, 200, JSON.stringify(answer));
  assert.equal(answer.outcome, 'OUTCOME_LOCALIZED');
  const { x, y, z } = answer.worldFromCamera.translationM;
  const error_m = Math.hypot(x - pose[3], y - pose[7], z - pose[11]);
  assert.ok(error_m < 0.05, `${error_m} m from the truth`);
});

test('fetch reads the reasons of real errors', async () => {
  const response = await fetch(url + LOCALIZE, {
    method: 'POST',
    headers: { 'Content-Type': 'application/json' },
    body: JSON.stringify({ scene: 'attic', frame: {} }),
  });
  assert.equal(response.status, 404);
  const error = await response.json();
  assert.equal(error.code, 'not_found');
  assert.equal(error.details[0].debug.reason, 'SCENE_NOT_FOUND');
});

test('@oarc/gpp-access is told the GeoPose of a real frame', async () => {
  const [width, height] = [640, 480];
  const params = new CameraParam();
  params.model = CAMERAMODEL.PINHOLE;
  // The recording's colour camera, with COLMAP's pixel centres.
  params.modelParams = [525, 525, 320.5, 240.5];
  const time = 1764000000123;
  const request = new GeoPoseRequest('request-1')
    .addSensor(new Sensor('camera', SENSORTYPE.camera))
    .addSensor(new Sensor('gps', SENSORTYPE.geolocation))
    .addCameraData(IMAGEFORMAT.JPG, [width, height], base64Of('color.jpg'), 0,
      new ImageOrientation(false, 0), params, time, 'camera', new Privacy())
    .addGeoLocationData(ANCHOR.latitude_deg, ANCHOR.longitude_deg, 520, 20, 20,
      0, 0, time, 'gps', new Privacy());
  const answer = await askGeoPose(`${url}/geopose`, request);
  const { position } = answer.geopose;
  // The world is East-North-Up at the anchor. The pose file is the depth
  // camera's, 2.5 cm beside the colour camera.
  const error_m = Math.hypot(
    (position.lon - ANCHOR.longitude_deg) * EAST_M - pose[3],
    (position.lat - ANCHOR.latitude_deg) * NORTH_M - pose[7],
    position.h - ANCHOR.height_m - pose[11]);
  assert.ok(error_m < 0.1, `${error_m} m from the truth`);
  assert.ok(answer.accuracy.position > 0 && answer.accuracy.position < 0.1);
});
