import assert from 'node:assert/strict';
import { test } from 'node:test';

import { scaleBar } from './scale.js';

test('the scale is the longest round length that fits', () => {
  assert.deepEqual(scaleBar(50, 100), { pixels: 100, text: '2 m' });
  assert.deepEqual(scaleBar(49, 100), { pixels: 98, text: '2 m' });
  assert.deepEqual(scaleBar(51, 100), { pixels: 51, text: '1 m' });
  assert.deepEqual(scaleBar(300, 100), { pixels: 60, text: '20 cm' });
});

test('there is a scale however near or far one looks', () => {
  assert.deepEqual(scaleBar(1, 100), { pixels: 50, text: '50 m' });
  assert.deepEqual(scaleBar(5000, 100), { pixels: 500, text: '10 cm' });
});
