import assert from 'node:assert/strict';
import test from 'node:test';

import { create, type MessageInitShape } from '@bufbuild/protobuf';

import { StreamStateResponseSchema, type StreamStateResponse } from
  '../gen/treeline/v1/navigation_pb.js';
import { AgentStream, PATIENCE_MS, SILENCE_MS } from './stream.js';

// Whatever waits for what was said has heard it then.
const settle = () => new Promise<void>((resolve) => { setImmediate(resolve); });

// A stream that says what a test has it say.
class FakeStream implements AsyncIterable<StreamStateResponse> {
  private said: (StreamStateResponse | Error)[] = [];
  private wake = (): void => {};

  constructor(readonly signal: AbortSignal) {}

  async emit(
      fields: MessageInitShape<typeof StreamStateResponseSchema>):
      Promise<void> {
    this.said.push(create(StreamStateResponseSchema, fields));
    this.wake();
    await settle();
  }

  async fail(): Promise<void> {
    this.said.push(new Error('gone'));
    this.wake();
    await settle();
  }

  async* [Symbol.asyncIterator](): AsyncIterator<StreamStateResponse> {
    for (;;) {
      const next = this.said.shift();
      if (next instanceof Error) throw next;
      if (next !== undefined) yield next;
      else await new Promise<void>((resolve) => { this.wake = resolve; });
    }
  }
}

// A clock that a test turns, and what the stream told.
function setUp() {
  const sources: FakeStream[] = [];
  const told: string[] = [];
  const timers = new Map<number, { at: number; work: () => void }>();
  let now = 0;
  let next = 1;
  const stream = new AgentStream({
    watch: (signal) => {
      const source = new FakeStream(signal);
      sources.push(source);
      return source;
    },
    later: (work, ms) => {
      timers.set(next, { at: now + ms, work });
      return next++;
    },
    forget: (timer) => void timers.delete(timer),
  }, {
    state: (state) => told.push(`state ${state.time}`),
    scene: () => told.push('scene'),
    event: (event) => told.push(`event ${event.text}`),
    link: (link, retry) => told.push(retry > 0 ? `${link} ${retry}` : link),
    garbled: (error) => told.push(`garbled ${error.name}`),
  });
  const pass = (ms: number): void => {
    const until = now + ms;
    for (;;) {
      const due = [...timers].filter(([, timer]) => timer.at <= until)
          .sort(([, a], [, b]) => a.at - b.at)[0];
      if (due === undefined) break;
      timers.delete(due[0]);
      now = due[1].at;
      due[1].work();
    }
    now = until;
  };
  stream.start();
  return { stream, sources, told, pass };
}

test('the first message makes the connection live', async () => {
  const { sources, told } = setUp();
  await sources[0].emit({ state: { timeS: 1 }, scene: {},
    events: [{ number: 1n, text: 'hello' }] });
  assert.deepEqual(told, ['live', 'state 1', 'scene', 'event hello']);
});

test('a message without a state is no news', async () => {
  const { sources, told, pass } = setUp();
  await sources[0].emit({});
  assert.deepEqual(told, []);
  pass(PATIENCE_MS);
  assert.deepEqual(told, ['lost 500']);
});

test('an error is a lost connection at once', async () => {
  const { sources, told } = setUp();
  await sources[0].emit({ state: { timeS: 1 } });
  await sources[0].fail();
  assert.equal(told.at(-1), 'lost 500');
  assert.equal(sources[0].signal.aborted, true);
});

test('silence is a lost connection, too', async () => {
  const { sources, told, pass } = setUp();
  await sources[0].emit({ state: { timeS: 1 } });
  pass(SILENCE_MS - 1);
  assert.equal(told.at(-1), 'state 1');
  pass(1);
  assert.equal(told.at(-1), 'lost 500');
});

test('it comes back by itself, and waits longer each time', async () => {
  const { sources, told, pass } = setUp();
  for (const wait of [500, 1000, 2000, 4000, 4000]) {
    await sources.at(-1)?.fail();
    assert.equal(told.at(-1), `lost ${wait}`);
    const attempts = sources.length;
    pass(wait - 1);
    assert.equal(sources.length, attempts);
    pass(1);
    assert.equal(sources.length, attempts + 1);
  }
  await sources.at(-1)?.emit({ state: { timeS: 9 } });
  assert.deepEqual(told.slice(-2), ['live', 'state 9']);
  await sources.at(-1)?.fail();
  assert.equal(told.at(-1), 'lost 500');
});

test('an agent that accepts and says nothing is given up', async () => {
  const { sources, told, pass } = setUp();
  pass(PATIENCE_MS);
  assert.deepEqual(told, ['lost 500']);
  assert.equal(sources[0].signal.aborted, true);
});

test('what an old connection still says is not heard', async () => {
  const { sources, told, pass } = setUp();
  await sources[0].fail();
  pass(500);
  await sources[0].emit({ state: { timeS: 1 } });
  await sources[0].fail();
  assert.deepEqual(told, ['lost 500']);
});

test('somebody who looks again does not wait', async () => {
  const { stream, sources, pass } = setUp();
  stream.retryNow();
  assert.equal(sources.length, 1);
  await sources[0].fail();
  stream.retryNow();
  assert.equal(sources.length, 2);
  await sources[1].emit({ state: { timeS: 1 } });
  pass(1000);
  assert.equal(sources.length, 2);
});

test('a garbled message is told, and the next one heard', async () => {
  const { sources, told } = setUp();
  await sources[0].emit({ state: { timeS: NaN } });
  await sources[0].emit({ state: { timeS: 2 } });
  assert.deepEqual(told, ['live', 'garbled ProtoError', 'state 2']);
});
