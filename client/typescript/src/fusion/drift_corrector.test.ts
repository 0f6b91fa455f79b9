import assert from 'node:assert/strict';
import test from 'node:test';

import { fromAxisAngle } from '../geometry/rotation.js';
import { compose, IDENTITY, inverse, type RigidTransform } from
  '../geometry/rigid_transform.js';
import { norm, subtract } from '../geometry/vector3.js';
import { DriftCorrector, type Fix } from './drift_corrector.js';
import { diagonal, fused, squaredDistance, transported } from
  './gaussian_pose.js';
import { radians, type DriftParameters } from './parameters.js';

const at = (x: number, y = 0, z = 0, yawDeg = 0): RigidTransform => ({
  rotation: fromAxisAngle({ x: 0, y: 0, z: radians(yawDeg) }),
  translationM: { x, y, z },
});

const COVARIANCE = diagonal(0.01 ** 2, radians(0.3) ** 2);
// The truth: the world is the device's frame, moved by 10 m.
const WORLD = at(10);

// A device whose camera moves along x, and fixes of it.
class Device {
  readonly corrector: DriftCorrector;
  timeMs = 0;
  xM = 0;

  constructor(parameters: Partial<DriftParameters> = {}) {
    this.corrector = new DriftCorrector(parameters);
    this.corrector.track(0, at(0));
  }

  step(metres = 0.1, ms = 100) {
    this.timeMs += ms;
    this.xM += metres;
    return this.corrector.track(this.timeMs, at(this.xM));
  }

  walk(steps: number, metres = 0.1) {
    for (let i = 1; i < steps; ++i) this.step(metres);
    return this.step(metres);
  }

  // Where the camera is now, if the world were `world`.
  fix(world = WORLD, rest: Partial<Fix> = {}) {
    return this.corrector.addFix({ captureTimeMs: this.timeMs,
      worldFromCamera: compose(world, at(this.xM)), covariance: COVARIANCE,
      confidence: 0.97, ...rest });
  }

  lock() {
    assert.equal(this.fix(), 'held');
    this.step();
    assert.equal(this.fix(), 'locked');
    const estimate = this.step();
    assert.equal(estimate.state, 'locked');
    return estimate;
  }
}

const isNear = (a: RigidTransform, b: RigidTransform, toleranceM = 1e-9) =>
  norm(subtract(a.translationM, b.translationM)) <= toleranceM;

test('one fix is no world, two that agree are', () => {
  const device = new Device();
  assert.equal(device.step().state, 'searching');
  assert.equal(device.fix(), 'held');
  const alone = device.step();
  assert.equal(alone.state, 'tentative');
  assert.equal(alone.worldFromDevice, null);
  assert.equal(alone.sinceGoodFixS, null);
  assert.equal(device.fix(), 'locked');
  const estimate = device.step();
  assert.equal(estimate.state, 'locked');
  assert.ok(estimate.snapped);
  assert.ok(isNear(estimate.worldFromDevice!, WORLD));
  assert.ok(isNear(estimate.worldFromCamera!, compose(WORLD, at(device.xM))));
  assert.ok(Math.abs(estimate.sinceGoodFixS! - 0.1) < 1e-9);
  assert.equal(device.step().snapped, false);
});

test('fixes of one view count as one, until there are four', () => {
  const device = new Device();
  const verdicts = [];
  for (let i = 0; i < 4; ++i) {
    verdicts.push(device.fix());
    device.step(0);
  }
  assert.deepEqual(verdicts, ['held', 'held', 'held', 'locked']);
});

test('doubtful fixes must be more', () => {
  const device = new Device();
  // Odds of 3 each: 81 after four, 243 after five.
  const verdicts = [];
  for (let i = 0; i < 5; ++i) {
    verdicts.push(device.fix(WORLD, { confidence: 0.75 }));
    device.step();
  }
  assert.deepEqual(verdicts, ['held', 'held', 'held', 'held', 'locked']);
});

test('of two that agree as often, none is the world', () => {
  const device = new Device();
  device.fix();
  device.step();
  device.fix(at(-10), { confidence: 0.75 });
  device.step();
  device.fix(at(-10), { confidence: 0.75 });
  device.step();
  assert.equal(device.fix(), 'held');
  device.step();
  assert.equal(device.fix(), 'locked');
});

test('one wrong fix moves nothing, however sure it is', () => {
  const device = new Device();
  device.lock();
  assert.equal(device.fix(at(13), { confidence: 1,
    covariance: diagonal(1e-8, 1e-8) }), 'held');
  const estimate = device.walk(20);
  assert.ok(isNear(estimate.worldFromDevice!, WORLD));
  assert.equal(estimate.contradictingViews, 1);
  assert.equal(device.fix(), 'applied');
  assert.equal(device.step().contradictingViews, 0);
});

test('a single fix within the gate moves the world by little', () => {
  // Even where the world is so uncertain that the gate lets all pass.
  const device = new Device({ driftMPerSqrtM: 1, lostSigmaM: 100 });
  device.lock();
  device.walk(100);
  assert.equal(device.fix(at(10.5)), 'held');
  device.step();
  assert.equal(device.fix(at(10.1)), 'applied');
  assert.ok(isNear(device.walk(50).worldFromDevice!, WORLD, 0.1));
});

test('two views that agree correct an uncertain world further', () => {
  const device = new Device({ driftMPerSqrtM: 0.2, lostSigmaM: 100 });
  device.lock();
  device.walk(50);
  assert.equal(device.fix(at(10.3)), 'held');
  device.step();
  assert.equal(device.fix(at(10.3)), 'jumped');
  assert.ok(isNear(device.walk(80).worldFromDevice!, at(10.3), 0.02));
});

test('a world is given up for three views that agree, and smoothly', () => {
  const device = new Device();
  device.lock();
  const other = at(10.6, 0, 0);
  assert.equal(device.fix(other), 'held');
  device.step();
  // Too near to the first to count.
  assert.equal(device.fix(other), 'held');
  device.walk(4);
  assert.equal(device.fix(other), 'held');
  assert.equal(device.walk(4).contradictingViews, 2);
  assert.equal(device.fix(other), 'jumped');
  let last = device.corrector.track(
      device.timeMs += 100, at(device.xM)).worldFromDevice!;
  for (let i = 0; i < 60; ++i) {
    const { worldFromDevice, snapped } = device.step();
    assert.equal(snapped, false);
    const stepM = norm(subtract(
        worldFromDevice!.translationM, last.translationM));
    assert.ok(stepM <= 0.005 + 1e-9, `${stepM} m in 0.1 s`);
    last = worldFromDevice!;
  }
  assert.ok(isNear(device.walk(80).worldFromDevice!, other, 0.02));
});

test('far corrections are not crept to', () => {
  const device = new Device();
  device.lock();
  for (let i = 0; i < 2; ++i) {
    device.fix(at(14));
    device.walk(5);
  }
  assert.equal(device.fix(at(14)), 'jumped');
  const estimate = device.step();
  assert.ok(estimate.snapped);
  assert.ok(isNear(estimate.worldFromDevice!, at(14), 0.01));
});

test('a rotation is corrected at the camera, at its own pace', () => {
  const device = new Device();
  device.lock();
  device.walk(50);
  const camera = compose(WORLD, at(device.xM));
  // Turned by 10 degrees about where the camera is: nothing moves there.
  const turned = compose(compose(camera, at(0, 0, 0, 10)),
      inverse(at(device.xM)));
  const here = () => device.corrector.track(
      device.timeMs += 100, at(device.xM));
  // Three views of one place: the camera turns, and turns back.
  for (const yawDeg of [0, 20, 40]) {
    const view = compose(at(device.xM), at(0, 0, 0, yawDeg));
    device.corrector.track(device.timeMs += 500, view);
    device.fix(WORLD, { worldFromCamera: compose(turned, view) });
  }
  const before = device.corrector.track(device.timeMs += 500, at(device.xM));
  const after = here();
  assert.ok(norm(subtract(before.worldFromCamera!.translationM,
      after.worldFromCamera!.translationM)) < 0.006);
  const turnedDeg = 2 * Math.acos(Math.min(1, Math.abs(
      compose(after.worldFromCamera!, inverse(before.worldFromCamera!))
          .rotation.w))) * 180 / Math.PI;
  assert.ok(Math.abs(turnedDeg - 0.2) < 1e-6, `${turnedDeg} degrees`);
});

test('without good fixes the world is lost, and says for how long', () => {
  const device = new Device({ lostAfterS: 2 });
  device.lock();
  const late = device.walk(20, 0);
  assert.equal(late.state, 'lost');
  assert.ok(late.worldFromDevice !== null);
  assert.ok(late.sinceGoodFixS! > 2);
  assert.equal(device.fix(), 'applied');
  assert.equal(device.step().state, 'locked');
});

test('what is lost is found elsewhere by two views, and snaps', () => {
  const device = new Device({ lostAfterS: 2 });
  device.lock();
  device.walk(20);
  assert.equal(device.fix(at(10.5)), 'held');
  assert.equal(device.step().state, 'lost');
  assert.equal(device.fix(at(10.5)), 'jumped');
  const estimate = device.step();
  assert.equal(estimate.state, 'locked');
  assert.ok(estimate.snapped);
});

test('fixes that nobody can use are ignored', () => {
  const device = new Device();
  device.walk(150);
  assert.equal(device.fix(WORLD, { confidence: 0.49 }), 'ignored_confidence');
  assert.equal(device.fix(WORLD, { covariance: diagonal(0.1, 1e-4) }),
      'ignored_uncertain');
  assert.equal(device.fix(WORLD, { covariance: diagonal(1e-4, 0.1) }),
      'ignored_uncertain');
  // Before the history and after it.
  assert.equal(device.fix(WORLD, { captureTimeMs: 1000 }),
      'ignored_untracked');
  assert.equal(device.fix(WORLD, { captureTimeMs: device.timeMs + 1 }),
      'ignored_untracked');
  assert.equal(device.corrector.state, 'searching');
});

test('what is no fix is refused', () => {
  const device = new Device();
  const indefinite = diagonal(1e-4, 1e-4);
  indefinite[0] = -1;
  const asymmetric = diagonal(1e-4, 1e-4);
  asymmetric[1] = 5e-5;
  for (const bad of [{ covariance: [1] }, { confidence: 1.1 },
    { confidence: NaN }, { captureTimeMs: NaN }, { covariance: indefinite },
    { covariance: asymmetric },
    { worldFromCamera: { ...IDENTITY, rotation: { w: 2, x: 0, y: 0, z: 0 } } },
  ]) {
    assert.throws(() => device.fix(WORLD, bad), RangeError);
  }
  assert.throws(() => device.corrector.track(0, IDENTITY), RangeError);
  assert.throws(() => device.corrector.track(50, at(NaN)), RangeError);
  assert.throws(() => device.corrector.track(Infinity, at(0)), RangeError);
  // None of it has done anything.
  device.lock();
  assert.throws(() => new DriftCorrector({ lockViews: 0 }), RangeError);
  assert.throws(() => new DriftCorrector({ minConfidence: 2 }), RangeError);
});

test('a covariance that is only semidefinite is a covariance', () => {
  const device = new Device();
  assert.equal(
      device.fix(WORLD, { covariance: diagonal(0, 0) }), 'held');
});

test('a fix between two poses belongs between them', () => {
  const device = new Device();
  device.step(0.2, 200);
  // At 50 ms the camera was at 5 cm.
  const past = { captureTimeMs: 50, worldFromCamera: compose(WORLD, at(0.05)) };
  device.fix(WORLD, past);
  device.step(0.2, 200);
  assert.equal(device.fix(), 'locked');
  assert.ok(isNear(device.step().worldFromDevice!, WORLD));
});

test('what nobody supports is forgotten', () => {
  const device = new Device({ hypothesisLifetimeS: 1 });
  device.fix();
  assert.equal(device.walk(9).state, 'tentative');
  assert.equal(device.walk(2).state, 'searching');
  assert.equal(device.fix(), 'held');
});

test('only so many guesses are kept, the newest', () => {
  const device = new Device({ maxHypotheses: 2 });
  for (const x of [0, 20, 40]) {
    device.fix(at(x));
    device.step();
  }
  // The first was forgotten, the last was not.
  assert.equal(device.fix(at(0)), 'held');
  device.step();
  assert.equal(device.fix(at(40)), 'locked');
});

test('a picture counts once', () => {
  const device = new Device();
  assert.equal(device.fix(at(20)), 'held');
  for (let i = 0; i < 10; ++i) {
    assert.equal(device.fix(at(20)), 'ignored_repeated');
  }
  assert.equal(device.corrector.state, 'tentative');
  device.step();
  // What was ignored has not counted.
  assert.equal(device.fix(WORLD, { confidence: 0.1 }), 'ignored_confidence');
  assert.equal(device.fix(), 'held');
});

test('contradicting views are counted no further than needed', () => {
  const device = new Device();
  device.lock();
  // Odds of 1: no number of them is ever enough.
  for (let i = 0; i < 20; ++i) {
    assert.equal(device.fix(at(20), { confidence: 0.5 }), 'held');
    device.walk(4);
  }
  assert.equal(device.step().contradictingViews, 3);
});

test('a reset forgets the world, but not when it last was good', () => {
  const device = new Device();
  device.lock();
  device.corrector.trackingReset();
  const estimate = device.step();
  assert.equal(estimate.state, 'searching');
  assert.equal(estimate.worldFromDevice, null);
  assert.equal(estimate.trackingBroke, false);
  assert.ok(estimate.sinceGoodFixS! > 0);
});

test('a gap, a leap and a spin of the tracking are noticed', () => {
  for (const [ms, pose] of [[1100, at(0.3)], [100, at(1.5)],
    [100, at(0.3, 0, 0, 90)]] as const) {
    const device = new Device();
    device.lock();
    const estimate = device.corrector.track(device.timeMs + ms, pose);
    assert.ok(estimate.trackingBroke);
    assert.equal(estimate.state, 'searching');
  }
});

test('an error of rotation becomes one of position on the way', () => {
  // 0.01 rad about z, 3 m along x: 3 cm along y.
  const covariance = transported(
      diagonal(0, 1e-4), { x: 3, y: 0, z: 0 });
  assert.ok(Math.abs(covariance[0]!) < 1e-15);
  assert.ok(Math.abs(covariance[7]! - 9e-4) < 1e-12);
  assert.ok(Math.abs(covariance[14]! - 9e-4) < 1e-12);
  // y of position with z of rotation: the same sign.
  assert.ok(Math.abs(covariance[11]! - 3e-4) < 1e-12);
  assert.ok(Math.abs(covariance[16]! + 3e-4) < 1e-12);
});

test('two poses are one by their information', () => {
  // 1 with variance 1 and 4 with variance 2: 2 with variance 2/3.
  const both = fused(
      { worldFromCamera: at(1), covariance: diagonal(1, 1) },
      { worldFromCamera: at(4), covariance: diagonal(2, 1) });
  assert.ok(Math.abs(both.worldFromCamera.translationM.x - 2) < 1e-12);
  assert.ok(Math.abs(both.covariance[0]! - 2 / 3) < 1e-12);
  assert.ok(Math.abs(both.covariance[35]! - 1 / 2) < 1e-12);
  assert.ok(Math.abs(squaredDistance(
      { worldFromCamera: at(1), covariance: diagonal(1, 1) },
      { worldFromCamera: at(4), covariance: diagonal(2, 1) }) - 3) < 1e-12);
});
