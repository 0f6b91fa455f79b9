import assert from 'node:assert/strict';
import { test } from 'node:test';

import { restAfter } from './pace.js';

test('slow pictures are drawn half of the time at most', () => {
  assert.equal(restAfter(16), 0);
  assert.equal(restAfter(120), 120);
  assert.equal(restAfter(9000), 500);
});
