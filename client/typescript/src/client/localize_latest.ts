// The newest picture of a camera, localized again and again.

import { TreelineError } from './error.js';
import type { CallOptions } from './treeline_client.js';
import type { LocalizeAnswer, LocalizeQuery } from './types.js';

/** One picture, and when it was taken. */
export interface TimedQuery {
  /** On the clock of the tracking, if the answer goes to DriftCorrector. */
  readonly captureTimeMs: number;
  readonly query: LocalizeQuery;
}

export interface LatestOptions {
  /** Queries on their way at a time, at least 1. Default: 1. */
  readonly maxInFlight?: number;
  /** Of each query. */
  readonly timeoutMs?: number;
  /** 'auto': one WebSocket for all, or calls where there is none. Default. */
  readonly transport?: 'auto' | 'calls';
  /** Ends the stream and cancels what is on its way. */
  readonly signal?: AbortSignal;
}

/** What became of one picture. A failed query ends nothing but itself. */
export type TimedAnswer = {
  readonly captureTimeMs: number;
  /** Pictures that newer ones replaced, since the answer before this one. */
  readonly dropped: number;
} & ({ readonly answer: LocalizeAnswer } | { readonly error: TreelineError });

type Localize = (
    query: LocalizeQuery, options: CallOptions) => Promise<LocalizeAnswer>;

// Resolves whoever waits for a change.
class Bell {
  private ring: () => void = () => {};
  private rung: Promise<void> = Promise.resolve();

  constructor() {
    this.renew();
  }

  get next(): Promise<void> {
    return this.rung;
  }

  strike(): void {
    this.ring();
    this.renew();
  }

  private renew(): void {
    this.rung = new Promise((resolve) => {
      this.ring = resolve;
    });
  }
}

interface InFlight {
  readonly captureTimeMs: number;
  readonly dropped: number;
  result?: { answer: LocalizeAnswer } | { error: TreelineError };
}

/**
 * Answers in the order of capture; a picture that is not newer than the one
 * before it is dropped. Ends when the source has ended and all is answered,
 * and cancels what is left when its reader leaves. Throws what the source
 * throws.
 */
export async function* localizeLatest(localize: Localize,
    source: AsyncIterable<TimedQuery>, options: LatestOptions):
    AsyncGenerator<TimedAnswer, void, void> {
  const { maxInFlight = 1, timeoutMs } = options;
  if (!(Number.isInteger(maxInFlight) && maxInFlight >= 1)) {
    throw new RangeError(`maxInFlight: ${maxInFlight} is not at least 1`);
  }
  const stop = new AbortController();
  const bell = new Bell();
  const abort = () => {
    stop.abort();
    bell.strike();
  };
  options.signal?.addEventListener('abort', abort);
  if (options.signal?.aborted === true) abort();
  const frames = source[Symbol.asyncIterator]();
  const inFlight: InFlight[] = [];
  let waiting: TimedQuery | null = null;
  let newestMs = -Infinity;
  let dropped = 0;
  let ended = false;
  let failure: { cause: unknown } | null = null;

  const send = () => {
    while (waiting !== null && inFlight.length < maxInFlight &&
        !stop.signal.aborted) {
      const { captureTimeMs, query } = waiting;
      const entry: InFlight = { captureTimeMs, dropped };
      waiting = null;
      dropped = 0;
      inFlight.push(entry);
      localize(query, { signal: stop.signal,
        ...timeoutMs !== undefined && { timeoutMs } }).then(
          (answer) => { entry.result = { answer }; },
          (error: unknown) => {
            entry.result = { error: error instanceof TreelineError ? error :
              new TreelineError('internal', String(error), '', {}, null,
                  { cause: error }) };
          }).then(() => bell.strike());
    }
  };
  const read = async () => {
    try {
      while (!stop.signal.aborted) {
        const { done, value } = await frames.next();
        if (done === true) break;
        if (value.captureTimeMs <= newestMs) {
          dropped += 1;
          continue;
        }
        newestMs = value.captureTimeMs;
        if (waiting !== null) dropped += 1;
        waiting = value;
        bell.strike();
      }
    } catch (cause) {
      failure = { cause };
    }
    ended = true;
    bell.strike();
  };

  void read();
  try {
    while (!stop.signal.aborted) {
      send();
      const first = inFlight[0];
      if (first?.result !== undefined) {
        inFlight.shift();
        yield { captureTimeMs: first.captureTimeMs, dropped: first.dropped,
          ...first.result };
        continue;
      }
      if (ended && inFlight.length === 0 && waiting === null) break;
      await bell.next;
    }
    if (failure !== null) throw (failure as { cause: unknown }).cause;
  } finally {
    options.signal?.removeEventListener('abort', abort);
    stop.abort();
    // Not awaited: a camera may have no further picture for long.
    frames.return?.().catch(() => {});
  }
}

/** Pictures that a render loop has, as a source for localizeLatest(). */
export class FrameQueue implements AsyncIterable<TimedQuery> {
  private readonly frames: TimedQuery[] = [];
  private readonly bell = new Bell();
  private ended = false;

  /** Of a queue that has ended: does nothing. */
  push(captureTimeMs: number, query: LocalizeQuery): void {
    if (this.ended) return;
    this.frames.push({ captureTimeMs, query });
    this.bell.strike();
  }

  /** No further picture will come. */
  end(): void {
    this.ended = true;
    this.bell.strike();
  }

  async* [Symbol.asyncIterator](): AsyncGenerator<TimedQuery, void, void> {
    for (;;) {
      const frame = this.frames.shift();
      if (frame !== undefined) {
        yield frame;
      } else if (this.ended) {
        return;
      } else {
        await this.bell.next;
      }
    }
  }
}
