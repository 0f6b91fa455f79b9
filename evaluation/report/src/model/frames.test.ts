import assert from 'node:assert/strict';
import { test } from 'node:test';
import { answersFrom, explanation, frameTitle, hardest, isNear, quantile,
  reasonText, refusalText } from './frames.js';
import type { Frame, Picture } from './report_data.js';
import { firstMethod, frameAt } from './testing_fixtures.js';

function pictureOf(frame: number, changes: Partial<Picture> = {}): Picture {
  const picture = firstMethod().page.pictures[0] as Picture;
  return { ...picture, frame, ...changes };
}

test('both errors decide whether a frame is near', () => {
  const frame = frameAt(firstMethod(), 0);
  const with_ = (m: number | null, deg: number | null): Frame =>
    ({ ...frame, translation_error_m: m, rotation_error_deg: deg });
  assert.ok(isNear(with_(0.049, 4.9)));
  assert.ok(!isNear(with_(0.05, 4.9)));
  assert.ok(!isNear(with_(0.049, 5)));
  assert.ok(!isNear(with_(null, null)));
});

test('confident answers are those that can be checked', () => {
  // 25 of 0.95, 5 of 0.35, and a wild one without.
  const { per_frame: frames } = firstMethod();
  assert.equal(answersFrom(frames, 0.95), 25);
  assert.equal(answersFrom(frames, 0.3), 30);
  assert.equal(answersFrom(frames, 0), 31);
});

test('reasons are words', () => {
  assert.equal(reasonText('TOO_FEW_INLIERS'), 'too few inliers');
  assert.equal(reasonText('CONTRADICTS_PRIOR'), 'contradicts the prior');
  assert.equal(reasonText('SOMETHING_NEW'), 'something new');
  assert.equal(reasonText(null), 'no reason given');
});

test('a refused pose is told with its error, where that is known', () => {
  const frame = frameAt(firstMethod(), 31);
  assert.match(refusalText(frame), /^too few inliers: refused .* 2\.0 cm/);
  assert.equal(refusalText({ ...frame, refused: null }), 'too few inliers');
});

test('a picture says what is known about its frame', () => {
  const method = firstMethod();
  assert.equal(explanation(pictureOf(31), method),
      'Not localized: too few inliers: refused a pose 2.0 cm and 1.00° off. ' +
      '7 of 0 predictions agree (0 %; the ' +
      'median frame has 80 %). The nearest training camera is 46 cm and 13° ' +
      'away.');
  const text = explanation(pictureOf(14, { error_direction: 'depth',
    claimed_deviation_m: 0.021 }), method);
  assert.match(text, /^Off by 3\.0 cm and 0\.30°, mostly along the viewing/);
  assert.match(text, /It claims a deviation of 2\.1 cm\./);
  assert.doesNotMatch(explanation(pictureOf(14, { error_direction: null }),
      method), /mostly|claims/);
});

test('errors and lost frames come before large errors', () => {
  const { per_frame: frames } = firstMethod();
  assert.deepEqual(hardest(frames, 4).map((frame) => frame.stem),
      ['failed', '<b>&"\'', 'wild', 'seq-01/frame-29']);
  const unknown = { ...frameAt(firstMethod(), 0), translation_error_m: null,
    rotation_error_deg: null };
  assert.deepEqual(hardest([unknown], 4), []);
});

test('the dot of a frame says which it is', () => {
  const method = firstMethod();
  assert.equal(frameTitle(frameAt(method, 4)),
      'seq-01/frame-4: 1.0 cm, 0.10°, 40 of 50 inliers');
  assert.equal(frameTitle(frameAt(method, 31)), '<b>&"\': not localized, ' +
    'too few inliers: refused a pose 2.0 cm and 1.00° off');
  assert.equal(frameTitle(frameAt(method, 32)), 'failed: error');
});

test('quantiles lie between the nearest ranks', () => {
  assert.equal(quantile([], 0.5), null);
  assert.equal(quantile([3], 0.99), 3);
  assert.equal(quantile([4, 1, 2, 3], 0.5), 2.5);
  assert.equal(quantile([10, 0], 0.95), 9.5);
});
