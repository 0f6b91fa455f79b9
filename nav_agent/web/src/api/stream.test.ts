import assert from 'node:assert/strict';
import test from 'node:test';

import { AgentStream, PATIENCE_MS, SILENCE_MS, type Source } from './stream.js';

class FakeSource implements Source {
  isClosed = false;
  private listeners = new Map<string, (event: { data?: unknown }) => void>();

  addEventListener(
      type: string, listener: (event: { data?: unknown }) => void): void {
    this.listeners.set(type, listener);
  }

  close(): void {
    this.isClosed = true;
  }

  emit(type: string, data?: unknown): void {
    this.listeners.get(type)?.({ data: JSON.stringify(data) });
  }
}

// A clock that a test turns, and what the stream told.
function setUp() {
  const sources: FakeSource[] = [];
  const told: string[] = [];
  const timers = new Map<number, { at: number; work: () => void }>();
  let now = 0;
  let next = 1;
  const stream = new AgentStream('stream', {
    open: () => {
      const source = new FakeSource();
      sources.push(source);
      return source;
    },
    now: () => now,
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

test('the first message makes the connection live', () => {
  const { sources, told } = setUp();
  sources[0].emit('state', { time_s: 1 });
  sources[0].emit('event', { number: 1, text: 'hello' });
  assert.deepEqual(told, ['live', 'state 1', 'event hello']);
});

test('an error is a lost connection at once', () => {
  const { sources, told } = setUp();
  sources[0].emit('state', { time_s: 1 });
  sources[0].emit('error');
  assert.equal(told.at(-1), 'lost 500');
  assert.equal(sources[0].isClosed, true);
});

test('silence is a lost connection, too', () => {
  const { sources, told, pass } = setUp();
  sources[0].emit('state', { time_s: 1 });
  pass(SILENCE_MS - 1);
  assert.equal(told.at(-1), 'state 1');
  pass(1);
  assert.equal(told.at(-1), 'lost 500');
});

test('it comes back by itself, and waits longer each time', () => {
  const { sources, told, pass } = setUp();
  for (const wait of [500, 1000, 2000, 4000, 4000]) {
    sources.at(-1)?.emit('error');
    assert.equal(told.at(-1), `lost ${wait}`);
    const attempts = sources.length;
    pass(wait - 1);
    assert.equal(sources.length, attempts);
    pass(1);
    assert.equal(sources.length, attempts + 1);
  }
  sources.at(-1)?.emit('state', { time_s: 9 });
  assert.deepEqual(told.slice(-2), ['live', 'state 9']);
  sources.at(-1)?.emit('error');
  assert.equal(told.at(-1), 'lost 500');
});

test('an agent that accepts and says nothing is given up', () => {
  const { sources, told, pass } = setUp();
  pass(PATIENCE_MS);
  assert.deepEqual(told, ['lost 500']);
  assert.equal(sources[0].isClosed, true);
});

test('what an old connection still says is not heard', () => {
  const { sources, told, pass } = setUp();
  sources[0].emit('error');
  pass(500);
  sources[0].emit('state', { time_s: 1 });
  sources[0].emit('error');
  assert.deepEqual(told, ['lost 500']);
});

test('somebody who looks again does not wait', () => {
  const { stream, sources, pass } = setUp();
  stream.retryNow();
  assert.equal(sources.length, 1);
  sources[0].emit('error');
  stream.retryNow();
  assert.equal(sources.length, 2);
  sources[1].emit('state', { time_s: 1 });
  pass(1000);
  assert.equal(sources.length, 2);
});

test('a garbled message is told, and the next one heard', () => {
  const { sources, told } = setUp();
  sources[0].emit('state', { mode: 'idle' });
  sources[0].emit('state', { time_s: 2 });
  assert.deepEqual(told, ['live', 'garbled DecodeError', 'state 2']);
});
