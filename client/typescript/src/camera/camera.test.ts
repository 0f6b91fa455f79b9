import assert from 'node:assert/strict';
import test from 'node:test';

import { fromAxisAngle } from '../geometry/rotation.js';
import { IDENTITY, toColumnMajor4, transformPoint } from
  '../geometry/rigid_transform.js';
import type { Vector3 } from '../geometry/vector3.js';
import { cameraFromArCore, deviceFromCameraOfArCore } from './arcore.js';
import { cameraFromArKit, deviceFromCameraOfArKit } from './arkit.js';
import { cropped, gravityInCamera, pinhole, resized, type Camera } from
  './camera.js';
import { cameraFromColmap, colmapParameters, worldFromCameraOfColmap } from
  './colmap.js';
import { cameraFromOpenCv, worldFromCameraOfOpenCv } from './opencv.js';
import { fromOpenGlCamera, toOpenGlCamera } from './opengl_axes.js';
import { cameraFromWebXr, deviceFromCameraOfWebXr } from './webxr.js';

function near(actual: Vector3, x: number, y: number, z: number) {
  assert.ok(
      Math.hypot(actual.x - x, actual.y - y, actual.z - z) < 1e-12,
      `${JSON.stringify(actual)} is not (${x}, ${y}, ${z})`);
}

function project({ parameters }: Camera, { x, y, z }: Vector3) {
  const [fx, fy, cx, cy] = parameters as [number, number, number, number];
  return [fx * x / z + cx, fy * y / z + cy];
}

test('the optical axis of an ARKit camera meets the middle of the picture',
    () => {
      // A principal point in the middle of 1920 x 1440: between pixels 959 and
      // 960, at 959.5 by Treeline's count.
      const camera = cameraFromArKit(
          [1600, 0, 0, 0, 1500, 0, 960, 720, 1], 1920, 1440);
      assert.deepEqual(project(camera, { x: 0, y: 0, z: 3 }), [959.5, 719.5]);
      // 1600 * 0.2 / 2 = 160 to the right, 1500 * -0.4 / 2 = -300: above.
      assert.deepEqual(
          project(camera, { x: 0.2, y: -0.4, z: 2 }), [1119.5, 419.5]);
    });

test('an ARKit camera looks along its minus z', () => {
  // At (1, 2, 3), turned by 90 degrees about y: columns (0,0,-1), (0,1,0),
  // (1,0,0). ARKit's camera looks along -z of it: to (-1, 0, 0) of the world.
  const deviceFromCamera = deviceFromCameraOfArKit(
      [0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 2, 3, 1]);
  near(transformPoint(deviceFromCamera, { x: 0, y: 0, z: 5 }), -4, 2, 3);
  // What is below in the picture is below in the world.
  near(transformPoint(deviceFromCamera, { x: 0, y: 1, z: 0 }), 1, 1, 3);
  // To the right of the picture is x of ARKit's camera: -z of the world.
  near(transformPoint(deviceFromCamera, { x: 1, y: 0, z: 0 }), 1, 2, 2);
});

test('gravity points to the left of a picture whose right side is up', () => {
  // Half a turn about x is Treeline's camera upright in a y-up world.
  const upright = fromOpenGlCamera(IDENTITY);
  near(gravityInCamera(upright), 0, 9.81, 0);
  // The camera's x axis upwards: turned by +90 degrees about OpenGL's z.
  const turned = fromOpenGlCamera({
    rotation: fromAxisAngle({ x: 0, y: 0, z: Math.PI / 2 }),
    translationM: { x: 0, y: 0, z: 0 },
  });
  near(gravityInCamera(turned), -9.81, 0, 0);
});

test('ARCore gives x y z w, and OpenGL axes', () => {
  const camera = cameraFromArCore([500, 510], [320, 240], [640, 480]);
  // 500 * 0.1 + 319.5, 510 * 0.1 + 239.5.
  assert.deepEqual(project(camera, { x: 1, y: 1, z: 10 }), [369.5, 290.5]);
  // 90 degrees about y, as above.
  const s = Math.SQRT1_2;
  const deviceFromCamera =
      deviceFromCameraOfArCore([1, 2, 3], [0, s, 0, s]);
  near(transformPoint(deviceFromCamera, { x: 0, y: 0, z: 5 }), -4, 2, 3);
});

test('a WebXR projection matrix images a point where the camera does', () => {
  const [width, height] = [640, 480];
  // 2 fx / w with fx 480; 2 fy / h with fy 480; off the axis by 0.1 and -0.05.
  const p = [1.5, 0, 0, 0, 0, 2, 0, 0, 0.1, -0.05, -1.02, -1, 0, 0, -0.2, 0];
  const camera = cameraFromWebXr(p, width, height);
  assert.deepEqual(camera.parameters, [480, 480, 287.5, 227.5]);
  // The point 0.5 right, 0.25 up, 2 before an OpenGL camera. Clip space:
  // x = 1.5 * 0.5 - 0.1 * 2 = 0.55, y = 2 * 0.25 + 0.05 * 2 = 0.6, w = 2; on
  // the picture 0.275 and 0.3 of half its size from the middle, right and up.
  const [x, y] = project(camera, { x: 0.5, y: -0.25, z: 2 }) as
      [number, number];
  assert.ok(Math.abs(x - (320 + 0.275 * 320 - 0.5)) < 1e-9, `${x}`);
  assert.ok(Math.abs(y - (240 - 0.3 * 240 - 0.5)) < 1e-9, `${y}`);
});

test('what is no perspective projection is refused', () => {
  const orthographic = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1];
  assert.throws(() => cameraFromWebXr(orthographic, 640, 480), RangeError);
  assert.throws(() => cameraFromWebXr([1, 2], 640, 480), RangeError);
});

test('a WebXR view has OpenGL axes', () => {
  const view = deviceFromCameraOfWebXr(
      [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1.6, 0, 1]);
  near(transformPoint(view, { x: 0.1, y: 0.2, z: 3 }), 0.1, 1.4, -3);
  // And back again, for content that WebGL draws.
  const matrix = toColumnMajor4(toOpenGlCamera(view));
  [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1.6, 0, 1].forEach((value, i) =>
    assert.ok(Math.abs(matrix[i]! - value) < 1e-12, `entry ${i}`));
});

test('OpenCV pixels are Treeline pixels', () => {
  const matrix = [525, 0, 319.5, 0, 530, 239.5, 0, 0, 1];
  const camera = cameraFromOpenCv(matrix, 640, 480);
  assert.deepEqual(project(camera, { x: 0, y: 0, z: 1 }), [319.5, 239.5]);
  assert.deepEqual(
      cameraFromOpenCv(matrix, 640, 480, [0.1, 0.2, 0.3, 0.4]),
      { ...camera, model: 'OPENCV',
        parameters: [525, 530, 319.5, 239.5, 0.1, 0.2, 0.3, 0.4] });
  assert.deepEqual(
      cameraFromOpenCv(matrix, 640, 480, [0.1, 0.2, 0.3, 0.4, 0.5]).parameters,
      [525, 530, 319.5, 239.5, 0.1, 0.2, 0.3, 0.4, 0.5, 0, 0, 0]);
  assert.throws(() => cameraFromOpenCv(matrix, 640, 480, [1, 2, 3]),
      RangeError);
});

test('solvePnP maps the world into the camera', () => {
  // The camera stands at x = 4 and looks along the world's -x: rvec turns the
  // world by 90 degrees about y, so that -x comes to z.
  const worldFromCamera = worldFromCameraOfOpenCv(
      { x: 0, y: Math.PI / 2, z: 0 }, { x: 0, y: 0, z: 4 });
  near(transformPoint(worldFromCamera, { x: 0, y: 0, z: 0 }), 4, 0, 0);
  near(transformPoint(worldFromCamera, { x: 0, y: 0, z: 3 }), 1, 0, 0);
});

test('COLMAP counts from the corner, and maps the world into the camera',
    () => {
      const camera = cameraFromColmap(
          'SIMPLE_RADIAL', 640, 480, [500, 320, 240, 0.01]);
      assert.deepEqual(camera.parameters, [500, 319.5, 239.5, 0.01]);
      assert.deepEqual(colmapParameters(camera), [500, 320, 240, 0.01]);
      assert.deepEqual(
          cameraFromColmap('PINHOLE', 640, 480, [500, 501, 320, 240])
              .parameters,
          [500, 501, 319.5, 239.5]);
      const s = Math.SQRT1_2;
      near(transformPoint(worldFromCameraOfColmap(s, 0, s, 0, 0, 0, 4),
          { x: 0, y: 0, z: 3 }), 1, 0, 0);
    });

test('edges stay edges when a picture is made smaller', () => {
  const camera = pinhole({ widthPx: 1920, heightPx: 1440, fxPx: 1600,
    fyPx: 1600, cxPx: 959.5, cyPx: 719.5 });
  // The middle stays the middle: 639.5 / 2 of 640 pixels is 319.5.
  assert.deepEqual(resized(camera, 640, 480).parameters.map((value) =>
    Math.round(value * 1e9) / 1e9), [533.333333333, 533.333333333, 319.5,
    239.5]);
  assert.throws(() => resized(cameraFromColmap(
      'SIMPLE_PINHOLE', 640, 480, [500, 320, 240]), 320, 480), RangeError);
  // Pixel (100, 50) becomes pixel (0, 0).
  assert.deepEqual(cropped(camera, 100, 50, 800, 600), pinhole({
    widthPx: 800, heightPx: 600, fxPx: 1600, fyPx: 1600, cxPx: 859.5,
    cyPx: 669.5 }));
});
