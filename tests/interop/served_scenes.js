// treeline-server itself, with scenes it has learned, for clients that are not
// ours. With INTEROP_SERVER, INTEROP_TRAINER and INTEROP_SCENE (a folder with
// recording/ and room.treeline, of tests/integration/make_scene.cmake).
import { execFileSync, spawn } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync }
  from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';

const { INTEROP_TRAINER, INTEROP_SERVER, INTEROP_SCENE } = process.env;
const RECORDING = join(INTEROP_SCENE, 'recording');

export const ANCHOR = {
  latitude_deg: 48.137,
  longitude_deg: 11.575,
  height_m: 520,
  enu_from_world: { w: 1, x: 0, y: 0, z: 0 },
};

const stem =
    readFileSync(join(RECORDING, 'test.txt'), 'utf8').split('\n')[0].trim();

/** Of a held-out frame: color.jpg or depth.png. */
export const frameFile = (kind) => readFileSync(
    join(RECORDING, `${stem}.${kind}`));

/** worldFromCamera of its depth camera: 16 numbers, by rows. */
export const truePose =
    readFileSync(join(RECORDING, `${stem}.pose.txt`), 'utf8')
        .trim().split(/\s+/).map(Number);

// `room` answers with depth, `hall` is the same place without, and on Earth.
function putScenes(folder) {
  mkdirSync(join(folder, 'room', '1'), { recursive: true });
  mkdirSync(join(folder, 'hall', '1'), { recursive: true });
  cpSync(join(INTEROP_SCENE, 'room.treeline'),
      join(folder, 'room', '1', 'model.treeline'));
  execFileSync(INTEROP_TRAINER, ['train', '--dataset', `7scenes:${RECORDING}`,
    '--frames', join(RECORDING, 'train.txt'), '--method', 'rgb', '--trees', '2',
    '--quiet', '--output', join(folder, 'hall', '1', 'model.treeline')]);
  writeFileSync(join(folder, 'hall', 'scene.json'),
      JSON.stringify({ display_name: 'Hall', geo_anchor: ANCHOR }));
}

/** {grpc: 'host:port', url: of HTTP, stop}. */
export async function serveScenes() {
  const folder = mkdtempSync(join(tmpdir(), 'treeline-interop-'));
  putScenes(folder);
  const server = spawn(INTEROP_SERVER, ['--models', folder,
    '--listen', '127.0.0.1:0', '--admin-listen', '',
    '--http-listen', '127.0.0.1:0', '--drain-s', '0'],
  { stdio: ['ignore', 'pipe', 'inherit'] });
  const stop = () => {
    server.kill('SIGTERM');
    rmSync(folder, { recursive: true });
  };
  let grpc;
  let url;
  for await (const line of createInterface({ input: server.stdout })) {
    grpc ??= /^listening on (\S+)/.exec(line)?.[1];
    const http = /^http on (.*)$/.exec(line);
    if (http) url = `http://${http[1]}`;
    if (grpc && url) return { grpc, url, stop };
  }
  stop();
  throw new Error('the server ended');
}
