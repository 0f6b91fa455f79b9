// A clock that waits for nothing: when all work rests, the next sleeper is due.

import type { Tools } from '../client/retry.js';

interface Sleeper {
  readonly atMs: number;
  readonly wake: () => void;
}

export class PlayedTools implements Tools {
  private timeMs = 0;
  private sleepers: Sleeper[] = [];

  constructor(private readonly chance = 0) {}

  nowMs(): number {
    return this.timeMs;
  }

  random(): number {
    return this.chance;
  }

  sleep(ms: number, signal: AbortSignal): Promise<void> {
    return new Promise((resolve) => {
      if (signal.aborted) {
        resolve();
        return;
      }
      const sleeper = { atMs: this.timeMs + ms, wake: resolve };
      this.sleepers.push(sleeper);
      signal.addEventListener('abort', () => {
        this.sleepers = this.sleepers.filter((other) => other !== sleeper);
        resolve();
      });
      setImmediate(() => this.wakeNext());
    });
  }

  private wakeNext(): void {
    const [first] = this.sleepers.sort((a, b) => a.atMs - b.atMs);
    if (first === undefined) return;
    this.sleepers.shift();
    this.timeMs = first.atMs;
    first.wake();
  }
}
