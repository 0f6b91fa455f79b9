import assert from 'node:assert/strict';
import { text } from 'node:stream/consumers';
import test, { type TestContext } from 'node:test';

import type { MessageInitShape } from '@bufbuild/protobuf';
import { Code, ConnectError, type ServiceImpl } from '@connectrpc/connect';

import { pinhole } from '../camera/camera.js';
import { ErrorInfoSchema, RetryInfoSchema } from
  '../gen/google/rpc/status_pb.js';
import { RgbdSensor } from '../gen/treeline/v1/camera_pb.js';
import { DepthRegistration, Orientation } from
  '../gen/treeline/v1/frame_pb.js';
import { NotLocalizedReason, Outcome, RelocalizationService,
  type LocalizeRequest, type LocalizeResponseSchema } from
  '../gen/treeline/v1/relocalization_pb.js';
import { SceneService, SceneState } from '../gen/treeline/v1/scenes_pb.js';
import { IDENTITY } from '../geometry/rigid_transform.js';
import { serve, type Handler } from '../testing/fake_server.js';
import { TreelineError } from './error.js';
import { SYSTEM_TOOLS } from './retry.js';
import { newTraceparent } from './traceparent.js';
import { fixOf, TreelineClient, type ClientOptions } from
  './treeline_client.js';

const PICTURE = new Uint8Array([0xff, 0xd8, 0xff, 0xe0]);
const COVARIANCE = Array.from({ length: 36 }, (_, i) => i / 100);
const LOCALIZED: MessageInitShape<typeof LocalizeResponseSchema> = {
  outcome: Outcome.LOCALIZED,
  worldFromCamera: { rotation: { w: 0, x: 1, y: 0, z: 0 },
    translationM: { x: 1, y: 2, z: 3 } },
  covariance: COVARIANCE,
  poseSensor: RgbdSensor.DEPTH,
  inliers: 30,
  samples: 40,
  inlierRatio: 0.75,
  confidence: 0.97,
  confidenceThreshold: 0.9,
  focalScale: 0.955,
  camera: { model: 'SIMPLE_PINHOLE', widthPx: 40, heightPx: 30,
    parameters: [31, 19.5, 14.5] },
  scene: 'kitchen',
  modelVersion: '3',
  timings: { totalMs: 12 },
};

type Localize = ServiceImpl<typeof RelocalizationService>['localize'];

async function serverOf(context: TestContext, localize: Localize,
    plain?: Handler) {
  const server = await serve((router) => {
    router.service(RelocalizationService, { localize });
    router.service(SceneService, {
      listScenes: () => ({ scenes: [
        { scene: 'attic', state: SceneState.FAILED,
          failure: { code: 'DATA_LOSS', message: 'corrupt model' } },
        { scene: 'kitchen', state: SceneState.READY, modelVersion: '3',
          versions: [{ version: '3' }, { version: '2' }],
          displayName: 'Kitchen',
          geoAnchor: { latitudeDeg: 48, longitudeDeg: 11, heightM: 500 },
          model: { method: 'universal', calibration: { color: {
            model: 'PINHOLE', widthPx: 640, heightPx: 480,
            parameters: [525, 525, 319.5, 239.5] } },
          boundsMinInWorldM: { x: 0, y: -1, z: 0 },
          boundsMaxInWorldM: { x: 5, y: 4, z: 2.7 } } }] }),
      getScene: ({ scene }) => {
        throw new ConnectError(`no scene ${scene}`, Code.NotFound, {}, [
          { desc: ErrorInfoSchema, value: { reason: 'SCENE_NOT_FOUND',
            domain: 'treeline', metadata: { scene } } }]);
      },
    });
  }, plain);
  context.after(() => server.close());
  return server;
}

async function clientOf(context: TestContext, localize: Localize,
    options: Partial<ClientOptions> = {}, plain?: Handler) {
  const { url } = await serverOf(context, localize, plain);
  return new TreelineClient({ servers: url, ...options });
}

const isError = (code: string, reason = '') => (error: unknown) => {
  assert.ok(error instanceof TreelineError, String(error));
  assert.equal(error.code, code, error.message);
  assert.equal(error.reason, reason);
  return true;
};

test('a localized answer has its pose, and says whose it is', async (t) => {
  const client = await clientOf(t, () => LOCALIZED);
  const answer = await client.localize({ scene: 'kitchen', color: PICTURE });
  assert.ok(answer.localized);
  assert.deepEqual(answer.worldFromCamera, { rotation: { w: 0, x: 1, y: 0,
    z: 0 }, translationM: { x: 1, y: 2, z: 3 } });
  assert.deepEqual(answer.covariance, COVARIANCE);
  assert.equal(answer.poseSensor, 'depth');
  assert.equal(answer.confidence, 0.97);
  assert.equal(answer.inliers, 30);
  assert.equal(answer.focalScale, 0.955);
  assert.deepEqual(answer.camera, { model: 'SIMPLE_PINHOLE', widthPx: 40,
    heightPx: 30, parameters: [31, 19.5, 14.5] });
  assert.equal(answer.timings.totalMs, 12);
  assert.ok(answer.roundTripMs > 0);
  assert.deepEqual(fixOf(answer, 7), { captureTimeMs: 7, confidence: 0.97,
    worldFromCamera: answer.worldFromCamera, covariance: COVARIANCE });
});

test('not localized is an answer, and no fix', async (t) => {
  const client = await clientOf(t, () => ({
    outcome: Outcome.NOT_LOCALIZED,
    reason: NotLocalizedReason.POORLY_CONSTRAINED,
    candidates: [{ scene: 'hall', similarity: 0.5, tried: true,
      outcome: Outcome.NOT_LOCALIZED, confidence: 0.1, inliers: 3 }],
  }));
  const answer = await client.localize({ color: PICTURE });
  assert.ok(!answer.localized);
  assert.equal(answer.reason, 'POORLY_CONSTRAINED');
  assert.deepEqual(answer.candidates, [{ scene: 'hall', similarity: 0.5,
    tried: true, localized: false, confidence: 0.1, inliers: 3 }]);
  assert.equal(fixOf(answer, 7), null);
});

test('an answer that makes no sense is an error', async (t) => {
  for (const response of [{}, { outcome: Outcome.LOCALIZED },
    { ...LOCALIZED, covariance: [1] },
    { ...LOCALIZED, worldFromCamera: {} }]) {
    const client = await clientOf(t, () => response);
    await assert.rejects(
        client.localize({ color: PICTURE }), isError('internal'));
  }
});

test('everything that a query says arrives', async (t) => {
  let asked: LocalizeRequest | undefined;
  const client = await clientOf(t, (request) => {
    asked = request;
    return LOCALIZED;
  });
  const camera = pinhole({ widthPx: 2, heightPx: 1, fxPx: 3, fyPx: 4, cxPx: 5,
    cyPx: 6 });
  await client.localize({
    scene: 'kitchen', modelVersion: '2', camera, sideUp: 'left',
    sideUpIsGuess: true, seed: 2n ** 63n, timeBudgetMs: 250,
    minConfidence: 0, wantsCorrespondences: true,
    color: { widthPx: 2, heightPx: 1,
      data: new Uint8Array([1, 2, 3, 4, 5, 6]) },
    depth: { unitM: 0.001, depthScale: 1.5,
      image: { widthPx: 2, heightPx: 1, data: new Uint16Array([258, 65535]) },
      registration: { camera, colorFromDepth: IDENTITY } },
    gravityInCameraMps2: { x: 1, y: 2, z: 3 },
    prior: { worldFromCamera: IDENTITY, positionRadiusM: 1,
      rotationRadiusRad: 2 },
    positionPrior: { positionInWorldM: { x: 1, y: 0, z: 0 }, radiusM: 3 },
    heightBand: { minM: -1, maxM: 1 },
  });
  assert.ok(asked?.frame?.depth && asked.options);
  const { frame, options } = asked;
  assert.equal(asked.scene, 'kitchen');
  assert.equal(asked.modelVersion, '2');
  assert.ok(frame.color?.data.case === 'rgb8');
  assert.deepEqual([...frame.color.data.value.data], [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(frame.camera?.parameters, [3, 4, 5, 6]);
  assert.equal(frame.orientation, Orientation.LEFT_UP);
  assert.equal(frame.orientationIsGuess, true);
  assert.equal(frame.gravityInCameraMps2?.z, 3);
  assert.ok(frame.depth?.data.case === 'raw');
  // 258 is 0x0102: the low byte first.
  assert.deepEqual([...frame.depth.data.value.data], [2, 1, 255, 255]);
  assert.equal(frame.depth.registration, DepthRegistration.EXPLICIT);
  assert.equal(frame.depth.calibration?.colorFromDepth?.rotation?.w, 1);
  assert.equal(frame.depth.depthScale, 1.5);
  assert.equal(options.seed, 2n ** 63n);
  assert.equal(options.timeBudgetMs, 250);
  // Not left out for being 0.
  assert.equal(options.minConfidence, 0);
  assert.equal(options.includeCorrespondences, true);
  assert.equal(options.prior?.rotationRadiusRad, 2);
  assert.equal(options.positionPrior?.positionInWorldM?.x, 1);
  assert.equal(options.heightBand?.minM, -1);
  assert.equal(options.heightBand?.upInWorld, undefined);
});

test('a query without a word says nothing more', async (t) => {
  let asked: LocalizeRequest | undefined;
  const client = await clientOf(t, (request) => {
    asked = request;
    return LOCALIZED;
  });
  await client.localize({ color: new Blob([PICTURE]),
    candidateScenes: ['a', 'b'],
    depth: { image: PICTURE, unitM: 0.001,
      registration: 'scene_calibration' } });
  assert.ok(asked?.frame?.color?.data.case === 'encoded');
  assert.deepEqual([...asked.frame.color.data.value], [...PICTURE]);
  assert.deepEqual(asked.candidateScenes, ['a', 'b']);
  assert.equal(asked.frame.camera, undefined);
  assert.equal(asked.frame.depth?.registration,
      DepthRegistration.SCENE_CALIBRATION);
  assert.equal(asked.frame.depth?.depthScale, undefined);
  assert.equal(asked.options?.seed, undefined);
  assert.equal(asked.options?.minConfidence, undefined);
});

test('scenes have states, versions and cameras', async (t) => {
  const client = await clientOf(t, () => LOCALIZED);
  const [attic, kitchen] = await client.scenes();
  assert.equal(attic?.state, 'failed');
  assert.equal(attic?.failure, 'DATA_LOSS: corrupt model');
  assert.equal(attic?.camera, null);
  assert.equal(attic?.geoAnchor, null);
  assert.equal(attic?.boundsInWorldM, null);
  assert.equal(kitchen?.state, 'ready');
  assert.deepEqual(kitchen?.versions, ['3', '2']);
  assert.equal(kitchen?.method, 'universal');
  assert.deepEqual(kitchen?.camera?.parameters, [525, 525, 319.5, 239.5]);
  assert.deepEqual(kitchen?.boundsInWorldM,
      { min: { x: 0, y: -1, z: 0 }, max: { x: 5, y: 4, z: 2.7 } });
  assert.deepEqual(kitchen?.geoAnchor?.enuFromWorld,
      { w: 1, x: 0, y: 0, z: 0 });
});

test('errors have the server\'s reason and its details', async (t) => {
  const client = await clientOf(t, () => LOCALIZED);
  await assert.rejects(client.scene('cellar'), (error) =>
    isError('not_found', 'SCENE_NOT_FOUND')(error) &&
    (error as TreelineError).metadata['scene'] === 'cellar');
});

test('the time that RetryInfo says is waited for', async (t) => {
  let calls = 0;
  const pausesMs: number[] = [];
  const client = await clientOf(t, () => {
    calls += 1;
    if (calls > 1) return LOCALIZED;
    throw new ConnectError('full', Code.Unavailable,
        // Rounded up to whole seconds by the server.
        { 'Retry-After': '1' }, [{ desc: RetryInfoSchema, value: {
          retryDelay: { seconds: 0n, nanos: 120_000_000 } } }]);
  }, { tools: { ...SYSTEM_TOOLS, sleep: (ms, signal) => {
    pausesMs.push(ms);
    return SYSTEM_TOOLS.sleep(ms, signal);
  } } });
  assert.ok((await client.localize({ color: PICTURE })).localized);
  // The others are time-outs of attempts.
  assert.equal(pausesMs.filter((ms) => ms > 100 && ms <= 132).length, 1);
});

test('without RetryInfo it is Retry-After', async (t) => {
  const client = await clientOf(t, () => {
    throw new ConnectError('full', Code.Unavailable, { 'Retry-After': '7' });
  });
  await assert.rejects(client.localize({ color: PICTURE }), (error) =>
    isError('unavailable')(error) &&
    (error as TreelineError).retryAfterMs === 7000);
});

test('a server that is not there is unavailable, and another is asked',
    async (t) => {
      const gone = await serve(() => {});
      await gone.close();
      const there = await serverOf(t, () => LOCALIZED);
      const alone = new TreelineClient({ servers: gone.url,
        retry: { maxAttempts: 2 } });
      await assert.rejects(
          alone.localize({ color: PICTURE }), isError('unavailable'));
      const both = new TreelineClient({ servers: [gone.url, there.url] });
      assert.ok((await both.localize({ color: PICTURE })).localized);
      const health = await both.health();
      assert.deepEqual(health.map(({ reachable }) => reachable),
          [false, true]);
    });

test('the deadline is told to the server, and kept without it', async (t) => {
  let toldMs = '';
  const client = await clientOf(t, async (_, { requestHeader, signal }) => {
    toldMs = requestHeader.get('Connect-Timeout-Ms') ?? '';
    await new Promise((resolve) => signal.addEventListener('abort', resolve));
    return LOCALIZED;
  });
  const startMs = performance.now();
  await assert.rejects(client.localize({ color: PICTURE }, { timeoutMs: 1000 }),
      isError('deadline_exceeded'));
  assert.ok(performance.now() - startMs < 9000);
  assert.ok(Number(toldMs) > 0 && Number(toldMs) <= 1000, toldMs);
});

test('cancelling reaches the server', async (t) => {
  const cancel = new AbortController();
  let hungUp: (() => void) | undefined;
  const isOver = new Promise<void>((resolve) => { hungUp = resolve; });
  const client = await clientOf(t, async (_, { signal }) => {
    signal.addEventListener('abort', () => hungUp?.());
    cancel.abort();
    await isOver;
    return LOCALIZED;
  });
  await assert.rejects(
      client.localize({ color: PICTURE }, { signal: cancel.signal }),
      isError('canceled'));
  await isOver;
});

test('each attempt asks for a token', async (t) => {
  const told: (string | null)[] = [];
  let tokens = 0;
  const client = await clientOf(t, (_, { requestHeader }) => {
    told.push(requestHeader.get('Authorization'));
    if (told.length > 1) return LOCALIZED;
    throw new ConnectError('later', Code.Unavailable);
  }, { token: async () => `token-${++tokens}` });
  await client.localize({ color: PICTURE });
  assert.deepEqual(told, ['Bearer token-1', 'Bearer token-2']);
});

test('a token may stand still, or be missing', async (t) => {
  const told: (string | null)[] = [];
  const localize: Localize = (_, { requestHeader }) => {
    told.push(requestHeader.get('Authorization'));
    return LOCALIZED;
  };
  await (await clientOf(t, localize, { token: 'fixed' }))
      .localize({ color: PICTURE });
  await (await clientOf(t, localize)).localize({ color: PICTURE });
  assert.deepEqual(told, ['Bearer fixed', null]);
  const failing = await clientOf(t, localize, { token: async () => {
    throw new Error('logged out');
  } });
  await assert.rejects(
      failing.localize({ color: PICTURE }), isError('unauthenticated'));
});

test('a server says whether it is ready', async (t) => {
  for (const [status, ready] of [[200, true], [503, false]] as const) {
    const client = await clientOf(t, () => LOCALIZED, {},
        (request, response) => {
          assert.equal(request.url, '/readyz');
          response.writeHead(status).end('word\n');
        });
    const [health] = await client.health();
    assert.equal(health?.ready, ready);
    assert.equal(health?.reachable, true);
    assert.equal(health?.detail, 'word');
  }
});

test('a balancer is told of the scene where that is wanted', async (t) => {
  const named: (string | null)[] = [];
  const localize: Localize = (_, { requestHeader }) => {
    named.push(requestHeader.get('X-Treeline-Scene'));
    return LOCALIZED;
  };
  const { url } = await serverOf(t, localize);
  const silent = new TreelineClient({ servers: url });
  const naming = new TreelineClient({ servers: url, sceneHeader: true });
  await silent.localize({ color: PICTURE, scene: 'kitchen' });
  await naming.localize({ color: PICTURE, scene: 'kitchen-2.new_1' });
  await naming.localize({ color: PICTURE });
  await naming.localize({ color: PICTURE, scene: 'k\u00fcche\n' });
  assert.deepEqual(named, [null, 'kitchen-2.new_1', null, null]);
});

test('calls belong to the trace of their program', async (t) => {
  const named: (string | null)[] = [];
  const localize: Localize = (_, { requestHeader }) => {
    named.push(requestHeader.get('traceparent'));
    return LOCALIZED;
  };
  const { url } = await serverOf(t, localize);
  const made = newTraceparent();
  assert.match(made, /^00-[0-9a-f]{32}-[0-9a-f]{16}-01$/);
  assert.match(newTraceparent(false), /-00$/);
  assert.notEqual(made, newTraceparent());
  for (const told of [undefined, '', 'odd\n', `${made}\n`, made]) {
    const client = new TreelineClient(
        { servers: url, traceparent: () => told });
    await client.localize({ color: PICTURE });
  }
  assert.deepEqual(named, [null, null, null, null, made]);
});

test('what is no URL is refused', () => {
  assert.throws(() => new TreelineClient({ servers: [] }), TypeError);
  assert.throws(() => new TreelineClient({ servers: 'robot:8080' }), TypeError);
  assert.throws(() => new TreelineClient({ servers: '' }), TypeError);
});

test('a GeoPose is asked for in COLMAP\'s pixels and answered in ours',
    async (t) => {
      let asked: { sensorReadings: { cameraReadings: Record<string, unknown>[],
        geolocationReadings: Record<string, unknown>[] } } | undefined;
      let accepted: string | undefined;
      const s = Math.SQRT1_2;
      const client = await clientOf(t, () => LOCALIZED, { token: 'fixed' },
          async (request, response) => {
            asked = JSON.parse(await text(request));
            accepted = request.headers.accept;
            assert.equal(request.headers.authorization, 'Bearer fixed');
            response.writeHead(200).end(JSON.stringify({ id: '1',
              timestamp: 5000, type: 'geopose',
              accuracy: { position: 0.03, orientation: 1.5 },
              geopose: { position: { lat: 48, lon: 11, h: 500 },
                // Looks East: a quarter turn to the right from North.
                quaternion: { x: 0, y: 0, z: -s, w: s } } }));
          });
      const answer = await client.geoPose({
        captureTimeMs: 5000, color: PICTURE, widthPx: 640, heightPx: 480,
        turnClockwiseDeg: 90,
        camera: pinhole({ widthPx: 640, heightPx: 480, fxPx: 500, fyPx: 500,
          cxPx: 319.5, cyPx: 239.5 }),
        geolocation: { latitudeDeg: 48, longitudeDeg: 11, altitudeM: 500,
          accuracyM: 20 },
      });
      assert.equal(accepted, 'application/vnd.oscp+json;version=2.0');
      const reading = asked?.sensorReadings.cameraReadings[0];
      assert.deepEqual(reading?.['params'], { model: 'PINHOLE',
        modelParams: [500, 500, 320, 240] });
      assert.equal(reading?.['imageBytes'],
          Buffer.from(PICTURE).toString('base64'));
      assert.equal(
          asked?.sensorReadings.geolocationReadings[0]?.['latitude'], 48);
      assert.equal(answer.heightM, 500);
      assert.equal(answer.positionAccuracyM, 0.03);
      // The optical axis, z, is East: x of East, North, Up; what is below in
      // the picture is below.
      const { w, x, y, z } = answer.enuFromCamera;
      const column = (v: [number, number, number]) => {
        const [a, b, c] = v;
        return [(1 - 2 * (y * y + z * z)) * a + 2 * (x * y - w * z) * b +
          2 * (x * z + w * y) * c, 2 * (x * y + w * z) * a +
          (1 - 2 * (x * x + z * z)) * b + 2 * (y * z - w * x) * c,
        2 * (x * z - w * y) * a + 2 * (y * z + w * x) * b +
          (1 - 2 * (x * x + y * y)) * c].map((value) =>
          Math.round(value * 1e9) + 0);
      };
      assert.deepEqual(column([0, 0, 1]), [1e9, 0, 0]);
      assert.deepEqual(column([0, 1, 0]), [0, 0, -1e9]);
    });

test('no GeoPose is not found, with the evidence', async (t) => {
  const client = await clientOf(t, () => LOCALIZED, {}, (_, response) => {
    response.writeHead(422).end(JSON.stringify({ code: 'not_found',
      message: 'not localized', details: [{ type: 'google.rpc.ErrorInfo',
        value: '', debug: { reason: 'TOO_FEW_INLIERS', domain: 'treeline',
          metadata: { inliers: '3' } } }] }));
  });
  await assert.rejects(client.geoPose({ captureTimeMs: 0, color: PICTURE,
    widthPx: 1, heightPx: 1 }), (error) =>
    isError('not_found', 'TOO_FEW_INLIERS')(error) &&
    (error as TreelineError).metadata['inliers'] === '3');
});

test('a proxy\'s page is an error by its status', async (t) => {
  const client = await clientOf(t, () => LOCALIZED,
      { retry: { maxAttempts: 1 } },
      (_, response) => {
        response.writeHead(502).end('<html>Bad Gateway</html>');
      });
  await assert.rejects(client.geoPose({ captureTimeMs: 0, color: PICTURE,
    widthPx: 1, heightPx: 1 }), isError('unavailable'));
});
