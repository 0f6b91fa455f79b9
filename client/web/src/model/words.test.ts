import assert from 'node:assert/strict';
import { test } from 'node:test';

import { TreelineError, type LocalizeAnswer, type Scene } from
  '@treeline/client';

import { reasonInWords, sayingOfAnswer, sayingOfCamera, sayingOfError,
  whySceneCannotAnswer } from './words.js';

const refused = (reason: string) =>
  ({ localized: false, reason }) as LocalizeAnswer;

test('every reason of the service has words of its own', () => {
  const texts = ['TOO_FEW_SAMPLES', 'TOO_FEW_INLIERS', 'POORLY_CONSTRAINED',
    'LOW_CONFIDENCE', 'CONTRADICTS_PRIOR', 'CONTRADICTS_DEPTH',
    'UNKNOWN_CAMERA']
      .map((reason) => sayingOfAnswer(refused(reason)).text);
  assert.equal(new Set(texts).size, texts.length);
  for (const text of texts) assert.doesNotMatch(text, /[A-Z]_|undefined/);
});

test('so have those of other clients\' queries', () => {
  for (const reason of ['TOO_FEW_SAMPLES', 'TOO_FEW_INLIERS',
    'POORLY_CONSTRAINED', 'LOW_CONFIDENCE', 'CONTRADICTS_PRIOR',
    'CONTRADICTS_DEPTH', 'UNKNOWN_CAMERA', 'INVALID_REQUEST']) {
    assert.doesNotMatch(reasonInWords(reason), /[A-Z]_|undefined/);
  }
  assert.match(reasonInWords('NEW_ONE'), /NEW_ONE/);
});

test('a reason of a newer server is told as it is', () => {
  assert.match(sayingOfAnswer(refused('REASON_9')).text, /REASON_9/);
});

test('errors say what to do', () => {
  const of = (code: ConstructorParameters<typeof TreelineError>[0],
      reason = '') => sayingOfError(new TreelineError(code, 'm', reason)).text;
  assert.match(of('unauthenticated', 'TOKEN_MISSING'), /Enter one/);
  assert.match(of('unauthenticated', 'TOKEN_EXPIRED'), /expired/);
  assert.match(of('unavailable'), /keeps asking/);
  assert.equal(of('internal'), 'm');
  assert.match(sayingOfError(new Error('odd')).title, /this page/);
});

test('a camera that is not given has its remedy', () => {
  assert.match(sayingOfCamera('InsecureContext').text, /HTTPS/);
  assert.match(sayingOfCamera('NotAllowedError').text, /Allow/);
  assert.match(sayingOfCamera('AbortError').text, /AbortError/);
});

test('scenes that need depth are known', () => {
  const scene = (more: Partial<Scene>) =>
    ({ state: 'ready', method: 'universal', failure: '', ...more }) as Scene;
  assert.equal(whySceneCannotAnswer(scene({})), null);
  assert.equal(whySceneCannotAnswer(scene({ state: 'unloaded', method: null })),
      null);
  assert.match(whySceneCannotAnswer(scene({ method: 'rgbd' }))!, /depth/);
  assert.match(whySceneCannotAnswer(scene({ state: 'failed',
    failure: 'DATA_LOSS: bad' }))!, /DATA_LOSS/);
});
