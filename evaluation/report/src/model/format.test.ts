import assert from 'node:assert/strict';
import { test } from 'node:test';
import { bytes, cm, counted, datasetName, fixed, percent } from './format.js';

test('one lost frame of many is not none', () => {
  assert.equal(percent(1), '100 %');
  assert.equal(percent(0), '0 %');
  assert.equal(percent(4000 / 4001), '99.9 %');
  assert.equal(percent(1 / 4001), '0.1 %');
  assert.equal(percent(0.5), '50.0 %');
  assert.equal(percent(null), '–');
});

test('what is no number is a dash', () => {
  assert.equal(fixed(null, 2), '–');
  assert.equal(fixed(undefined, 2), '–');
  assert.equal(fixed(NaN, 2), '–');
  assert.equal(fixed(1.005, 1), '1.0');
  assert.equal(cm(0.0834, 1), '8.3');
  assert.equal(cm(null, 1), '–');
});

test('bytes go by powers of ten', () => {
  assert.equal(bytes(0), '0 B');
  assert.equal(bytes(999), '999 B');
  assert.equal(bytes(1000), '1.0 kB');
  assert.equal(bytes(999_960), '1.0 MB');
  assert.equal(bytes(34_200_000), '34.2 MB');
});

test('a recording is called by what says most', () => {
  assert.equal(datasetName('7scenes:/data/redkitchen'), 'redkitchen');
  assert.equal(datasetName('7scenes:/data/redkitchen/'), 'redkitchen');
  assert.equal(datasetName('tum:/data/tum-fr1-rpy/test'), 'tum-fr1-rpy/test');
  assert.equal(datasetName('7scenes:kitchen'), 'kitchen');
  assert.equal(datasetName('a:test'), 'test');
  assert.equal(datasetName('builtin'), 'builtin');
  assert.equal(datasetName(''), '');
});

test('one is counted without an s', () => {
  assert.equal(counted(1, 'frame'), '1 frame');
  assert.equal(counted(0, 'frame'), '0 frames');
  assert.equal(counted(1, 'estimate lies', 'estimates lie'), '1 estimate lies');
});
