import assert from 'node:assert/strict';
import test from 'node:test';

import { create, fromBinary, toBinary } from '@bufbuild/protobuf';
import { anyPack } from '@bufbuild/protobuf/wkt';

import { ErrorInfoSchema, StatusSchema } from '../gen/google/rpc/status_pb.js';
import { LocalizeResponseSchema, LocalizeStreamRequestSchema,
  LocalizeStreamResponseSchema, Outcome, RelocalizationService,
  type LocalizeStreamRequest } from
  '../gen/treeline/v1/relocalization_pb.js';
import { serve } from '../testing/fake_server.js';
import { FrameQueue, type LatestOptions, type TimedAnswer } from
  './localize_latest.js';
import type { Socket } from './localize_stream.js';
import { TreelineClient, type ClientOptions } from './treeline_client.js';

const settled = () => new Promise((resolve) => setImmediate(resolve));
const QUERY = { scene: 'hall', color: new Uint8Array([1, 2, 3]) };

// A socket whose server is the test.
class PlayedSocket implements Socket {
  binaryType = '';
  readyState = 0;
  onopen: ((event: never) => void) | null = null;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onclose: ((event: { code: number, reason: string }) => void) | null = null;
  readonly sent: LocalizeStreamRequest[] = [];

  constructor(readonly url: string, readonly protocols: string[]) {}

  send(data: Uint8Array): void {
    this.sent.push(fromBinary(LocalizeStreamRequestSchema, data));
  }
  close(): void {
    this.readyState = 3;
  }
  open(): Promise<unknown> {
    this.readyState = 1;
    this.onopen?.(undefined as never);
    return settled();
  }
  lose(code = 1006): Promise<unknown> {
    this.readyState = 3;
    this.onclose?.({ code, reason: '' });
    return settled();
  }
  answer(id: bigint, scene: string): Promise<unknown> {
    return this.say(create(LocalizeStreamResponseSchema, { id,
      result: { case: 'response', value: create(LocalizeResponseSchema,
          { outcome: Outcome.NOT_LOCALIZED, scene }) } }));
  }
  say(message: ReturnType<typeof create<
      typeof LocalizeStreamResponseSchema>>): Promise<unknown> {
    this.onmessage?.({ data: toBinary(
        LocalizeStreamResponseSchema, message).slice().buffer });
    return settled();
  }
}

class Played {
  readonly sockets: PlayedSocket[] = [];
  readonly queue = new FrameQueue();
  readonly results: TimedAnswer[] = [];
  done: Promise<void> = Promise.resolve();

  run(options: Partial<ClientOptions> = {}, latest: LatestOptions = {}): this {
    const client = new TreelineClient({ servers: 'http://127.0.0.1:9',
      retry: { maxAttempts: 1 }, makeSocket: (url, protocols) => {
        const socket = new PlayedSocket(url, protocols);
        this.sockets.push(socket);
        return socket;
      }, ...options });
    this.done = (async () => {
      for await (const result of client.localizeLatest(this.queue, latest)) {
        this.results.push(result);
      }
    })();
    return this;
  }
  async push(timeMs: number): Promise<void> {
    this.queue.push(timeMs, QUERY);
    // Through all that is done at once before it is sent.
    for (let i = 0; i < 10; ++i) await settled();
  }
  scenes(): (string | undefined)[] {
    return this.results.map((result) =>
      'answer' in result ? result.answer.scene : result.error.code);
  }
}

// Answers calls, as the stream does.
const answersCalls = (scene: string) => serve((router) => router.service(
    RelocalizationService, {
      localize: () => ({ outcome: Outcome.NOT_LOCALIZED, scene }),
    }));

test('a connection belongs to a trace, if its program has one', async () => {
  const trace = '00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01';
  const played = new Played().run({ token: 'abc', traceparent: () => trace });
  await played.push(1);
  assert.deepEqual(played.sockets[0]!.protocols,
      ['treeline.v1', 'treeline.bearer.abc', `treeline.traceparent.${trace}`]);
  await played.sockets[0]!.open();
  await played.sockets[0]!.answer(0n, 'a');
  played.queue.end();
  await played.done;
});

test('pictures go over one connection, and answers find their picture',
    async () => {
      const played = new Played().run({ token: 'abc.def' }, { maxInFlight: 2 });
      await played.push(1);
      const [socket] = played.sockets;
      assert.equal(socket!.url, 'ws://127.0.0.1:9' +
          '/treeline.v1.RelocalizationService/LocalizeStream');
      assert.deepEqual(socket!.protocols,
          ['treeline.v1', 'treeline.bearer.abc.def']);
      await socket!.open();
      await played.push(2);
      assert.deepEqual(socket!.sent.map(({ id }) => id), [0n, 1n]);
      assert.equal(socket!.sent[0]!.settings?.maxPending, 4);
      assert.equal(socket!.sent[1]!.settings, undefined);
      assert.equal(socket!.sent[0]!.localize?.scene, 'hall');
      // Its deadline goes with it.
      const budget = socket!.sent[0]!.localize?.options?.timeBudgetMs ?? 0;
      assert.ok(budget > 9000 && budget <= 10_000, `${budget}`);
      await socket!.answer(1n, 'second');
      await socket!.answer(0n, 'first');
      played.queue.end();
      await played.done;
      assert.deepEqual(played.scenes(), ['first', 'second']);
      assert.equal(played.sockets.length, 1);
      assert.equal(socket!.readyState, 3);
    });

test('an error in the stream is that of a call', async () => {
  const played = new Played().run();
  await played.push(1);
  const [socket] = played.sockets;
  await socket!.open();
  await socket!.say(create(LocalizeStreamResponseSchema, { id: 0n,
    result: { case: 'error', value: create(StatusSchema, { code: 5,
      message: 'no such scene', details: [anyPack(ErrorInfoSchema,
          create(ErrorInfoSchema, { reason: 'SCENE_NOT_FOUND' }))] }) } }));
  played.queue.end();
  await played.done;
  const [result] = played.results;
  assert.ok(result !== undefined && 'error' in result);
  assert.equal(result.error.code, 'not_found');
  assert.equal(result.error.reason, 'SCENE_NOT_FOUND');
  assert.equal(result.error.message, 'no such scene');
});

test('where there is no stream, each picture is a call', async () => {
  const server = await answersCalls('by call');
  const played = new Played().run({ servers: server.url });
  await played.push(1);
  await played.sockets[0]!.lose();
  while (played.results.length < 1) await settled();
  // It is not tried again at once.
  await played.push(2);
  while (played.results.length < 2) await settled();
  assert.equal(played.sockets.length, 1);
  played.queue.end();
  await played.done;
  assert.deepEqual(played.scenes(), ['by call', 'by call']);
  await server.close();
});

test('a picture whose stream breaks is asked again, and the next opens another',
    async () => {
      const server = await answersCalls('by call');
      const played = new Played().run({ servers: server.url });
      await played.push(1);
      await played.sockets[0]!.open();
      assert.equal(played.sockets[0]!.sent.length, 1);
      await played.sockets[0]!.lose(1001);
      while (played.results.length < 1) await settled();
      await played.push(2);
      await played.sockets[1]!.open();
      await played.sockets[1]!.answer(0n, 'by stream');
      played.queue.end();
      await played.done;
      assert.deepEqual(played.scenes(), ['by call', 'by stream']);
      await server.close();
    });

test('calls are made where they are asked for, or nothing else can be',
    async () => {
      const server = await answersCalls('by call');
      for (const [options, latest] of [
        [{}, { transport: 'calls' }],
        [{ makeSocket: null }, {}],
        [{ makeSocket: () => { throw new Error('by policy'); } }, {}],
        [{ token: 'no protocol, this' }, {}],
      ] as [Partial<ClientOptions>, LatestOptions][]) {
        const played =
            new Played().run({ servers: server.url, ...options }, latest);
        await played.push(1);
        while (played.results.length < 1) await settled();
        assert.deepEqual(played.scenes(), ['by call']);
        assert.equal(played.sockets.length, 0);
        played.queue.end();
        await played.done;
      }
      await server.close();
    });

test('another token opens another stream', async () => {
  let token = 'first';
  const played = new Played().run({ token: () => token });
  await played.push(1);
  await played.sockets[0]!.open();
  await played.sockets[0]!.answer(0n, 'a');
  token = 'second';
  await played.push(2);
  assert.equal(played.sockets[0]!.readyState, 3);
  assert.deepEqual(played.sockets[1]!.protocols,
      ['treeline.v1', 'treeline.bearer.second']);
  await played.sockets[1]!.open();
  await played.sockets[1]!.answer(0n, 'b');
  played.queue.end();
  await played.done;
  assert.deepEqual(played.scenes(), ['a', 'b']);
});

test('an answer that comes too late is nobody\'s', async () => {
  // Long enough for a machine under load to send it.
  const played = new Played().run({}, { timeoutMs: 1000 });
  await played.push(1);
  await played.sockets[0]!.open();
  assert.equal(played.sockets[0]!.sent.length, 1);
  while (played.results.length < 1) await settled();
  assert.deepEqual(played.scenes(), ['deadline_exceeded']);
  await played.push(2);
  await played.sockets[0]!.answer(0n, 'late');
  await played.sockets[0]!.answer(1n, 'in time');
  played.queue.end();
  await played.done;
  assert.deepEqual(played.scenes(), ['deadline_exceeded', 'in time']);
});
