import assert from 'node:assert/strict';
import test from 'node:test';

import { PlayedTools } from '../testing/played_tools.js';
import { TreelineError } from './error.js';
import { callWithRetries, DEFAULT_RETRY, Replicas, type Attempt } from
  './retry.js';

const unavailable = (retryAfterMs: number | null = null) =>
  new TreelineError('unavailable', 'busy', 'QUEUE_FULL', {}, retryAfterMs);

const hasCode = (code: string) => (error: unknown) =>
  error instanceof TreelineError && error.code === code;

interface Setting {
  readonly servers?: readonly string[];
  readonly timeoutMs?: number;
  readonly chance?: number;
  readonly signal?: AbortSignal;
}

// A call whose attempts answer one after the other: what is no string is
// thrown, and 'hang' never ends. Records when and where it was asked.
function playing(script: readonly (string | TreelineError)[],
    { servers = ['a'], timeoutMs = 10_000, chance = 0, signal }: Setting = {}) {
  const tools = new PlayedTools(chance);
  const asked: { server: string, atMs: number, timeoutMs: number }[] = [];
  const replicas = new Replicas(servers);
  const attempt = async ({ server, timeoutMs: limitMs }: Attempt) => {
    const next = script[asked.length];
    asked.push({ server, atMs: tools.nowMs(), timeoutMs: limitMs });
    if (next === 'hang') return new Promise<string>(() => {});
    if (typeof next === 'string') return next;
    throw next ?? new Error('nobody expected this attempt');
  };
  const call = () => callWithRetries(attempt, replicas, DEFAULT_RETRY,
      { timeoutMs, attemptTimeoutMs: timeoutMs / 2, signal }, tools);
  return { call, asked, tools };
}

test('what is unavailable is asked again, after longer and longer', async () => {
  const { call, asked } = playing(
      [unavailable(), unavailable(), unavailable(), 'ok']);
  assert.equal(await call(), 'ok');
  // Half of 50, 150 and 450 ms, where chance adds nothing.
  assert.deepEqual(asked.map(({ atMs }) => atMs), [0, 25, 100, 325]);
});

test('chance adds up to as much again', async () => {
  const { call, asked } = playing([unavailable(), 'ok'], { chance: 0.5 });
  await call();
  assert.equal(asked[1]!.atMs, 37.5);
});

test('a server that names a time is not asked before it', async () => {
  const { call, asked } = playing(
      [unavailable(1200), 'ok'], { chance: 0.5 });
  await call();
  assert.equal(asked[1]!.atMs, 1260);
});

test('four attempts are all', async () => {
  const { call, asked } = playing(new Array(9).fill(unavailable()));
  await assert.rejects(call(), hasCode('unavailable'));
  assert.equal(asked.length, 4);
});

test('a wait beyond the deadline is not begun', async () => {
  const { call, asked, tools } = playing(
      [unavailable(3000)], { timeoutMs: 2000 });
  await assert.rejects(call(), hasCode('unavailable'));
  assert.equal(asked.length, 1);
  assert.equal(tools.nowMs(), 0);
});

test('each attempt gets the time that is left', async () => {
  const { call, asked } = playing([unavailable(500), 'ok'],
      { timeoutMs: 2000 });
  await call();
  assert.deepEqual(asked.map(({ timeoutMs }) => timeoutMs), [2000, 1500]);
});

test('only what says when is asked again for want of a quota', async () => {
  const quota = new TreelineError(
      'resource_exhausted', '', 'RATE_LIMITED', {}, 100);
  const waiting = playing([quota, 'ok']);
  assert.equal(await waiting.call(), 'ok');
  assert.equal(waiting.asked[1]!.atMs, 100);
  const tooLarge = playing([new TreelineError('resource_exhausted', '')]);
  await assert.rejects(tooLarge.call(), hasCode('resource_exhausted'));
  assert.equal(tooLarge.asked.length, 1);
});

test('a quota is not evaded by another server', async () => {
  const { call, asked } = playing(
      [new TreelineError('resource_exhausted', '', '', {}, 100), 'ok'],
      { servers: ['a', 'b'] });
  await call();
  assert.equal(asked[1]!.atMs, 100);
});

test('other errors are not retried', async () => {
  for (const code of ['invalid_argument', 'not_found', 'unauthenticated',
    'internal', 'data_loss'] as const) {
    const { call, asked } = playing([new TreelineError(code, '')]);
    await assert.rejects(call(), hasCode(code));
    assert.equal(asked.length, 1);
  }
});

test('another server takes over at once, and is kept to', async () => {
  const { call, asked } = playing([unavailable(1000), 'ok', 'ok'],
      { servers: ['a', 'b'] });
  await call();
  await call();
  assert.deepEqual(asked.map(({ server, atMs }) => [server, atMs]),
      [['a', 0], ['b', 0], ['b', 0]]);
});

test('where all rest, the first that may be asked is', async () => {
  const { call, asked } = playing([unavailable(1000), unavailable(300), 'ok'],
      { servers: ['a', 'b'] });
  await call();
  assert.deepEqual(asked.map(({ server, atMs }) => [server, atMs]),
      [['a', 0], ['b', 0], ['b', 300]]);
});

test('a server that hangs leaves time for another', async () => {
  const { call, asked } = playing(['hang', 'ok'], { servers: ['a', 'b'] });
  assert.equal(await call(), 'ok');
  assert.deepEqual(asked.map(({ server, atMs }) => [server, atMs]),
      [['a', 0], ['b', 5000]]);
});

test('one server that hangs has all the time', async () => {
  const { call, tools } = playing(['hang'], { timeoutMs: 3000 });
  await assert.rejects(call(), hasCode('deadline_exceeded'));
  assert.equal(tools.nowMs(), 3000);
});

test('who cancels waits for nothing', async () => {
  const cancel = new AbortController();
  const hanging = playing(['hang'], { signal: cancel.signal });
  const call = hanging.call();
  cancel.abort('enough');
  await assert.rejects(call, (error) =>
    hasCode('canceled')(error) && (error as Error).cause === 'enough');
  const before = playing(['ok'], { signal: cancel.signal });
  await assert.rejects(before.call(), hasCode('canceled'));
  assert.equal(before.asked.length, 0);
});
