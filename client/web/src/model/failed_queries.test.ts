import assert from 'node:assert/strict';
import test from 'node:test';

import { failedQueriesOf, whyNot } from './failed_queries.js';

test('a list is read, and what is missing is empty', () => {
  assert.deepEqual(failedQueriesOf({ queries: [
    { name: 'a', time_utc: '2026-11-26T04:55:37.608Z', reason: 'X',
      scene: 'hall', status: 'OK', trace_id: '0af7' },
    { name: 'b', scene: 7 },
  ] }), [
    { name: 'a', timeUtc: '2026-11-26T04:55:37.608Z', reason: 'X',
      scene: 'hall', status: 'OK', traceId: '0af7' },
    { name: 'b', timeUtc: '', reason: '', scene: '', status: '', traceId: '' },
  ]);
  assert.deepEqual(failedQueriesOf({ queries: [] }), []);
});

test('what is no list is refused', () => {
  for (const answer of [{}, { queries: 'many' }, []]) {
    assert.throws(() => failedQueriesOf(answer), TypeError);
  }
});

test('every refusal says what to do', () => {
  assert.match(whyNot(401), /inspect/);
  assert.match(whyNot(403), /inspect/);
  assert.match(whyNot(404), /--record/);
  assert.match(whyNot(503), /503/);
});
