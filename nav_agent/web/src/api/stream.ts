// The agent's stream: reconnects, and tells at once when it is silent.

import { decodeEvent, decodeScene, decodeState } from './decode.js';
import type { RobotEvent, RobotScene, RobotState } from './types.js';

// What of EventSource is used.
export interface Source {
  addEventListener(
      type: string, listener: (event: { data?: unknown }) => void): void;
  close(): void;
}

export type Link = 'connecting' | 'live' | 'lost';

export interface StreamListener {
  state(state: RobotState): void;
  scene(scene: RobotScene): void;
  event(event: RobotEvent): void;
  // `retryInMs`: when the next attempt begins, if lost.
  link(link: Link, retryInMs: number): void;
  // A message could not be read.
  garbled(error: Error): void;
}

export interface StreamTools {
  open(url: string): Source;
  now(): number;
  later(work: () => void, ms: number): number;
  forget(timer: number): void;
}

// States come 10 times a second.
export const SILENCE_MS = 1500;
// Of an attempt to connect.
export const PATIENCE_MS = 5000;
const FIRST_RETRY_MS = 500;
const LONGEST_RETRY_MS = 4000;

export class AgentStream {
  private source: Source | null = null;
  private timer = 0;
  private failures = 0;
  private current: Link = 'connecting';

  constructor(
      private readonly url: string, private readonly tools: StreamTools,
      private readonly listener: StreamListener) {}

  get link(): Link {
    return this.current;
  }

  start(): void {
    this.connect();
  }

  stop(): void {
    this.tools.forget(this.timer);
    this.source?.close();
    this.source = null;
  }

  // Now rather than when the next attempt is due: the network is back, or
  // somebody looks at the page again.
  retryNow(): void {
    if (this.current === 'lost') this.connect();
  }

  private connect(): void {
    this.stop();
    const source = this.tools.open(this.url);
    this.source = source;
    const hear = <T>(type: string, decode: (value: unknown) => T,
                     tell: (value: T) => void): void => {
      source.addEventListener(type, (message) => {
        if (this.source !== source) return;
        this.heard();
        try {
          tell(decode(JSON.parse(String(message.data))));
        } catch (error) {
          this.listener.garbled(
              error instanceof Error ? error : new Error(String(error)));
        }
      });
    };
    hear('state', decodeState, (state) => this.listener.state(state));
    hear('scene', decodeScene, (scene) => this.listener.scene(scene));
    hear('event', decodeEvent, (event) => this.listener.event(event));
    source.addEventListener('error', () => {
      if (this.source === source) this.lose();
    });
    this.tools.forget(this.timer);
    this.timer = this.tools.later(() => this.lose(), PATIENCE_MS);
  }

  private heard(): void {
    this.failures = 0;
    if (this.current !== 'live') {
      this.current = 'live';
      this.listener.link('live', 0);
    }
    this.tools.forget(this.timer);
    this.timer = this.tools.later(() => this.lose(), SILENCE_MS);
  }

  private lose(): void {
    this.stop();
    const wait =
        Math.min(FIRST_RETRY_MS * 2 ** this.failures, LONGEST_RETRY_MS);
    ++this.failures;
    this.current = 'lost';
    this.listener.link('lost', wait);
    this.timer = this.tools.later(() => this.connect(), wait);
  }
}
