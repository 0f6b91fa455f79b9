// Trying again, and elsewhere, within one deadline.

import { TreelineError, treelineErrorOf } from './error.js';

/** Clock and chance, to be played in tests. */
export interface Tools {
  /** Monotonic. */
  nowMs(): number;
  /** Resolves after `ms`, or at once when `signal` aborts. */
  sleep(ms: number, signal: AbortSignal): Promise<void>;
  /** In [0, 1). */
  random(): number;
}

export const SYSTEM_TOOLS: Tools = {
  nowMs: () => performance.now(),
  random: () => Math.random(),
  sleep: (ms, signal) => new Promise((resolve) => {
    if (signal.aborted) {
      resolve();
      return;
    }
    const done = () => {
      clearTimeout(timer);
      signal.removeEventListener('abort', done);
      resolve();
    };
    const timer = setTimeout(done, ms);
    signal.addEventListener('abort', done);
  }),
};

export interface RetryPolicy {
  /** Attempts of one call in all, over all servers. */
  readonly maxAttempts: number;
  /** Before the second attempt; the next ones wait `multiplier` times as long,
   * up to maxBackoffMs, and each between half of it and all of it. */
  readonly firstBackoffMs: number;
  readonly maxBackoffMs: number;
  readonly multiplier: number;
}

export const DEFAULT_RETRY: RetryPolicy =
    { maxAttempts: 4, firstBackoffMs: 50, maxBackoffMs: 1000, multiplier: 3 };

/** One attempt: where, for how long, and what ends it. */
export interface Attempt {
  readonly server: string;
  readonly timeoutMs: number;
  readonly signal: AbortSignal;
}

interface Replica {
  readonly server: string;
  // Until when it wants to be left alone.
  restUntilMs: number;
}

/** Servers that give the same answers; the one that worked last is kept to. */
export class Replicas {
  private readonly replicas: Replica[];
  private good = 0;

  constructor(servers: readonly string[]) {
    this.replicas = servers.map((server) => ({ server, restUntilMs: 0 }));
  }

  get count(): number {
    return this.replicas.length;
  }

  /** The good one, else the next that does not rest, else the one that rests
   * least long. */
  choose(nowMs: number): Replica {
    const ring = this.replicas.map((_, i) =>
      this.replicas[(this.good + i) % this.replicas.length]!);
    return ring.find((replica) => replica.restUntilMs <= nowMs) ??
        ring.reduce((best, replica) =>
          replica.restUntilMs < best.restUntilMs ? replica : best);
  }

  keep(replica: Replica): void {
    this.good = this.replicas.indexOf(replica);
    replica.restUntilMs = 0;
  }

  rest(replica: Replica, untilMs: number): void {
    replica.restUntilMs = untilMs;
  }

  /** A quota is the client's own: other servers do not lend theirs. */
  restAll(untilMs: number): void {
    for (const replica of this.replicas) {
      replica.restUntilMs = Math.max(replica.restUntilMs, untilMs);
    }
  }
}

// UNAVAILABLE says that the call was not begun, or that it does no harm to ask
// again. RESOURCE_EXHAUSTED is also said of messages that are too large: only
// with a time to wait is there sense in it.
const isWorthRetrying = (error: TreelineError): boolean =>
  error.code === 'unavailable' ||
  (error.code === 'resource_exhausted' && error.retryAfterMs !== null);

export interface CallLimits {
  /** Of the whole call. */
  readonly timeoutMs: number;
  /** Of one attempt, where there is another server to ask. */
  readonly attemptTimeoutMs: number;
  readonly signal?: AbortSignal | undefined;
}

/**
 * Calls `attempt` until it resolves, cannot be retried, or the time is up. A
 * wait that would pass the deadline is not begun: the last error is thrown.
 */
export async function callWithRetries<T>(
    attempt: (attempt: Attempt) => Promise<T>, replicas: Replicas,
    policy: RetryPolicy, limits: CallLimits, tools: Tools): Promise<T> {
  const deadlineMs = tools.nowMs() + limits.timeoutMs;
  const { signal, release } = linkedSignal(limits.signal);
  try {
    for (let tried = 1; ; ++tried) {
      throwIfAborted(limits.signal);
      const startMs = tools.nowMs();
      const replica = replicas.choose(startMs);
      const waitMs = replica.restUntilMs - startMs;
      if (waitMs > 0) {
        if (startMs + waitMs >= deadlineMs) throw noTimeToWait(replica.server);
        await tools.sleep(waitMs, signal);
        throwIfAborted(limits.signal);
      }
      const leftMs = deadlineMs - tools.nowMs();
      if (leftMs <= 0) throw timeIsUp(replica.server);
      const timeoutMs = replicas.count === 1 ? leftMs :
        Math.min(leftMs, limits.attemptTimeoutMs);
      try {
        const answer = await withTimeout(
            (own) => attempt({ server: replica.server, timeoutMs, signal: own }),
            timeoutMs, signal, replica.server, tools);
        replicas.keep(replica);
        return answer;
      } catch (caught) {
        throwIfAborted(limits.signal);
        const error = treelineErrorOf(caught, replica.server);
        const nowMs = tools.nowMs();
        const wasCutShort = error.code === 'deadline_exceeded' &&
            nowMs < deadlineMs && timeoutMs < leftMs;
        if (!wasCutShort && !isWorthRetrying(error)) throw error;
        const untilMs = nowMs + pauseMs(error, tried, policy, tools);
        if (error.code === 'resource_exhausted') {
          replicas.restAll(untilMs);
        } else {
          replicas.rest(replica, untilMs);
        }
        const nextMs = Math.max(replicas.choose(nowMs).restUntilMs, nowMs);
        if (tried >= policy.maxAttempts || nextMs >= deadlineMs) throw error;
      }
    }
  } finally {
    release();
  }
}

// Never less than the server asks for; a little more, so that clients that were
// turned away together do not come back together.
function pauseMs(error: TreelineError, tried: number, policy: RetryPolicy,
    tools: Tools): number {
  const chance = tools.random();
  if (error.retryAfterMs !== null) return error.retryAfterMs * (1 + chance / 10);
  const backoffMs = Math.min(policy.maxBackoffMs,
      policy.firstBackoffMs * policy.multiplier ** (tried - 1));
  return backoffMs * (1 + chance) / 2;
}

const timeIsUp = (server: string): TreelineError => new TreelineError(
    'deadline_exceeded', `${server} did not answer in time`);

const noTimeToWait = (server: string): TreelineError => new TreelineError(
    'unavailable', `${server} wants to be asked later than the deadline`);

function throwIfAborted(signal: AbortSignal | undefined): void {
  if (signal?.aborted === true) {
    throw new TreelineError('canceled', 'the call was cancelled', '', {}, null,
        { cause: signal.reason });
  }
}

// A signal of our own that aborts with the caller's.
function linkedSignal(outer: AbortSignal | undefined):
    { signal: AbortSignal, abort: () => void, release: () => void } {
  const controller = new AbortController();
  const abort = () => controller.abort();
  if (outer?.aborted === true) abort();
  outer?.addEventListener('abort', abort);
  return {
    signal: controller.signal,
    abort,
    release: () => outer?.removeEventListener('abort', abort),
  };
}

// What `work` gives, or an error when the time is up: even work that does not
// look at its signal ends the wait.
async function withTimeout<T>(work: (signal: AbortSignal) => Promise<T>,
    timeoutMs: number, outer: AbortSignal, server: string, tools: Tools):
    Promise<T> {
  const { signal, abort, release } = linkedSignal(outer);
  const over = new AbortController();
  const timer = tools.sleep(timeoutMs, over.signal).then(() => {
    if (over.signal.aborted) return undefined;
    throw timeIsUp(server);
  });
  const cancelled = new Promise<never>((_, reject) =>
    outer.addEventListener('abort', () => reject(
        new TreelineError('canceled', 'the call was cancelled'))));
  const ended = new Promise<never>((_, reject) => timer.catch(reject));
  try {
    return await Promise.race([work(signal), ended, cancelled]);
  } finally {
    over.abort();
    abort();
    release();
  }
}
