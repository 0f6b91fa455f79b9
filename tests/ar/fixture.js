// treeline-server with a scene that it has learned, and a browser whose camera
// sees a held-out frame of it (make_scene.cmake).

import { spawn } from 'node:child_process';
import fs from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { createInterface } from 'node:readline';

import { launch, wrongsOf } from '../page/browser.js';

const { TREELINE_PAGE, TREELINE_PAGE_WORK, TREELINE_SCENE, TREELINE_SERVER } =
  process.env;
export const RECORDING = path.join(TREELINE_SCENE, 'recording');

// Of recordings in the layout of TUM, and nearly that of Kinects.
export const WIDTH_PX = 640;
export const HEIGHT_PX = 480;
export const FOCAL_PX = 525;

// Times of the held-out frames.
export const heldOut = fs.readFileSync(path.join(RECORDING, 'test.txt'), 'utf8')
    .trim().split(/\s+/);

// Those that tell the focal length, which the page guesses. The first ones see
// a wall and little else: they are answered once it is known.
export const telling = heldOut.slice(5);

const truths = new Map(
    fs.readFileSync(path.join(RECORDING, 'groundtruth.txt'), 'utf8').split('\n')
        .filter((line) => line !== '' && !line.startsWith('#'))
        .map((line) => line.split(' '))
        .map(([time, ...numbers]) => [time, numbers.map(Number)]));

// Where the camera was at that time.
export function trueCameraOf(time) {
  const [x, y, z, qx, qy, qz, qw] = truths.get(time);
  return { position: { x, y, z }, rotation: { w: qw, x: qx, y: qy, z: qz } };
}

// Where the picture of that time shows a point of the world, as a share of its
// size; null: behind the camera.
export function trueShareOf(time, [x, y, z]) {
  const [tx, ty, tz, qx, qy, qz, qw] = truths.get(time);
  const [dx, dy, dz] = [x - tx, y - ty, z - tz];
  // The rotation's inverse: rows of its matrix are columns.
  const inCamera = [
    [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy + qw * qz),
      2 * (qx * qz - qw * qy)],
    [2 * (qx * qy - qw * qz), 1 - 2 * (qx * qx + qz * qz),
      2 * (qy * qz + qw * qx)],
    [2 * (qx * qz + qw * qy), 2 * (qy * qz - qw * qx),
      1 - 2 * (qx * qx + qy * qy)],
  ].map(([a, b, c]) => a * dx + b * dy + c * dz);
  if (inCamera[2] <= 0) return null;
  return {
    x: (FOCAL_PX * inCamera[0] / inCamera[2] + WIDTH_PX / 2) / WIDTH_PX,
    y: (FOCAL_PX * inCamera[1] / inCamera[2] + HEIGHT_PX / 2) / HEIGHT_PX,
  };
}

// The point of the world that the picture of that time shows at a share of its
// size, so far ahead of the camera.
export function truePointAt(time, share, depthM) {
  const [tx, ty, tz, qx, qy, qz, qw] = truths.get(time);
  const ray = [(share.x - 0.5) * WIDTH_PX / FOCAL_PX * depthM,
    (share.y - 0.5) * HEIGHT_PX / FOCAL_PX * depthM, depthM];
  const rows = [
    [1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qw * qz),
      2 * (qx * qz + qw * qy)],
    [2 * (qx * qy + qw * qz), 1 - 2 * (qx * qx + qz * qz),
      2 * (qy * qz - qw * qx)],
    [2 * (qx * qz - qw * qy), 2 * (qy * qz + qw * qx),
      1 - 2 * (qx * qx + qy * qy)],
  ];
  return rows.map((row, i) => [tx, ty, tz][i] +
    row[0] * ray[0] + row[1] * ray[1] + row[2] * ray[2]);
}

// Starts treeline-server; ends it with `kill`.
export async function startServer(...flags) {
  const server = spawn(TREELINE_SERVER, ['--models',
    path.join(TREELINE_SCENE, 'models'), '--listen', '127.0.0.1:0',
    '--admin-listen', '', '--http-listen', '127.0.0.1:0', '--ar-page',
    TREELINE_PAGE, '--drain-s', '0', '--load-all', ...flags],
  { stdio: ['ignore', 'pipe', 'inherit'] });
  for await (const line of createInterface({ input: server.stdout })) {
    const match = /^ar page on (.*)$/.exec(line);
    if (match) return { url: match[1], kill: () => server.kill('SIGTERM') };
  }
  throw new Error('the server ended');
}

// What the server says of a picture, over HTTP.
export async function localizePicture({ url }, bytes) {
  const response = await fetch(
      new URL('/treeline.v1.RelocalizationService/Localize', url), {
        method: 'POST', headers: { 'Content-Type': 'application/json' },
        body: JSON.stringify({ scene: 'room',
          frame: { color: { encoded: bytes.toString('base64') } } }),
      });
  return response.json();
}

// Of Chromium's fake camera, whatever the film.
const FILM_RATE_HZ = 30;

// A browser whose camera sees one frame, or several, each for a second, again
// and again. Without a time, it has no camera.
export async function launchWithCamera(...times) {
  if (times.length === 0) return launch(TREELINE_PAGE_WORK);
  const film = path.join(
      fs.mkdtempSync(path.join(tmpdir(), 'treeline-ar-')), 'film.mjpeg');
  const count = times.length === 1 ? 1 : FILM_RATE_HZ;
  for (const time of times) {
    const frame = fs.readFileSync(path.join(RECORDING, 'rgb', `${time}.jpg`));
    for (let i = 0; i < count; ++i) fs.appendFileSync(film, frame);
  }
  return launch(TREELINE_PAGE_WORK, ['--use-fake-ui-for-media-stream',
    '--use-fake-device-for-media-stream',
    `--use-file-for-fake-video-capture=${film}`]);
}

// The page, and what it did wrong. `before` runs in it before all else.
export async function open(browser, url, options = {}, expected = null,
    before = () => {}) {
  const context = await browser.newContext({
    viewport: { width: 1200, height: 760 }, reducedMotion: 'reduce', ...options,
  });
  context.setDefaultTimeout(60000);
  const page = await context.newPage();
  await page.addInitScript(before);
  const wrongs = wrongsOf(page, url, expected);
  await page.goto(url);
  await page.waitForFunction(
      () => document.querySelector('#state')?.textContent !== '');
  return { page, wrongs, close: () => context.close() };
}

export const waitForState = (page, title) => page.waitForFunction(
    (wanted) => document.querySelector('#state').textContent === wanted, title,
    { polling: 50 });
