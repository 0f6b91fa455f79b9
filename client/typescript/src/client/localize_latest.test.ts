import assert from 'node:assert/strict';
import test from 'node:test';

import { TreelineError } from './error.js';
import { FrameQueue, localizeLatest, type TimedAnswer } from
  './localize_latest.js';
import type { CallOptions } from './treeline_client.js';
import type { LocalizeAnswer, LocalizeQuery } from './types.js';

const query = (scene: string): LocalizeQuery =>
  ({ scene, color: new Uint8Array() });
const answer = (scene: string) =>
  ({ localized: false, scene }) as LocalizeAnswer;
const settled = () => new Promise((resolve) => setImmediate(resolve));

// A server whose answers are given by hand, in any order.
class ManualServer {
  readonly asked: string[] = [];
  readonly open = new Map<string, {
    resolve: (answer: LocalizeAnswer) => void,
    reject: (error: unknown) => void }>();

  localize = ({ scene = '' }: LocalizeQuery, { signal }: CallOptions) => {
    this.asked.push(scene);
    return new Promise<LocalizeAnswer>((resolve, reject) => {
      this.open.set(scene, { resolve, reject });
      signal?.addEventListener('abort', () =>
        reject(new TreelineError('canceled', '')));
    });
  };

  async answer(scene: string) {
    this.open.get(scene)!.resolve(answer(scene));
    await settled();
  }
}

function collect(stream: AsyncIterable<TimedAnswer>) {
  const results: TimedAnswer[] = [];
  const done = (async () => {
    for await (const result of stream) results.push(result);
  })();
  return { results, done };
}

async function push(queue: FrameQueue, ...timesMs: number[]) {
  for (const timeMs of timesMs) {
    queue.push(timeMs, query(`${timeMs}`));
    await settled();
  }
}

test('a newer picture replaces the one that waits', async () => {
  const server = new ManualServer();
  const queue = new FrameQueue();
  const { results, done } = collect(
      localizeLatest(server.localize, queue, {}));
  await push(queue, 1, 2, 3, 4);
  assert.deepEqual(server.asked, ['1']);
  await server.answer('1');
  assert.deepEqual(server.asked, ['1', '4']);
  queue.end();
  await server.answer('4');
  await done;
  assert.deepEqual(results.map(({ captureTimeMs, dropped }) =>
    [captureTimeMs, dropped]), [[1, 0], [4, 2]]);
});

test('answers come in the order of capture', async () => {
  const server = new ManualServer();
  const queue = new FrameQueue();
  const { results, done } = collect(
      localizeLatest(server.localize, queue, { maxInFlight: 3 }));
  await push(queue, 1, 2, 3, 4);
  assert.deepEqual(server.asked, ['1', '2', '3']);
  await server.answer('3');
  await server.answer('2');
  assert.equal(results.length, 0);
  await server.answer('1');
  assert.deepEqual(results.map(({ captureTimeMs }) => captureTimeMs),
      [1, 2, 3]);
  queue.end();
  await server.answer('4');
  await done;
  assert.equal(results.length, 4);
});

test('a picture that is not newer is dropped', async () => {
  const server = new ManualServer();
  const queue = new FrameQueue();
  const { results, done } = collect(
      localizeLatest(server.localize, queue, { maxInFlight: 4 }));
  await push(queue, 5, 5, 4, 6);
  assert.deepEqual(server.asked, ['5', '6']);
  queue.end();
  queue.push(7, query('7'));
  await server.answer('5');
  await server.answer('6');
  await done;
  assert.deepEqual(results.map(({ dropped }) => dropped), [0, 2]);
});

test('a query that fails ends nothing but itself', async () => {
  const server = new ManualServer();
  const queue = new FrameQueue();
  const { results, done } = collect(
      localizeLatest(server.localize, queue, {}));
  await push(queue, 1, 2);
  server.open.get('1')!.reject(new TreelineError('unavailable', 'busy'));
  await settled();
  queue.end();
  await server.answer('2');
  await done;
  assert.ok('error' in results[0]! && results[0].error.code === 'unavailable');
  assert.ok('answer' in results[1]! && results[1].answer.scene === '2');
});

test('a signal ends the stream and cancels what is on its way', async () => {
  const server = new ManualServer();
  const queue = new FrameQueue();
  const stop = new AbortController();
  const { results, done } = collect(
      localizeLatest(server.localize, queue, { signal: stop.signal }));
  await push(queue, 1);
  stop.abort();
  await done;
  assert.deepEqual(results, []);
});

test('a reader that leaves cancels what is on its way', async () => {
  const server = new ManualServer();
  const queue = new FrameQueue();
  let cancelled = 0;
  const stream = localizeLatest((asked, options) => {
    options.signal?.addEventListener('abort', () => { cancelled += 1; });
    return server.localize(asked, options);
  }, queue, { maxInFlight: 2 });
  const first = stream.next();
  await push(queue, 1, 2);
  await server.answer('1');
  assert.equal((await first).done, false);
  await stream.return();
  assert.equal(cancelled, 2);
});

test('a source that throws ends the stream after its last answer',
    async () => {
      const server = new ManualServer();
      async function* camera() {
        yield { captureTimeMs: 1, query: query('1') };
        throw new Error('unplugged');
      }
      const { results, done } = collect(
          localizeLatest(server.localize, camera(), {}));
      const failed = assert.rejects(done, /unplugged/);
      await settled();
      await server.answer('1');
      await failed;
      assert.equal(results.length, 1);
    });

test('at least one query is on its way', async () => {
  await assert.rejects(
      localizeLatest(new ManualServer().localize, new FrameQueue(),
          { maxInFlight: 0 }).next(), RangeError);
});
