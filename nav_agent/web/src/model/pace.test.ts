import assert from 'node:assert/strict';
import { test } from 'node:test';

import { restAfter } from './pace.js';

test('slow pictures are drawn a third of the time', () => {
  assert.equal(restAfter(16), 0);
  assert.equal(restAfter(120), 240);
  assert.equal(restAfter(9000), 1000);
});
