// The agent's stream: reconnects, and tells at once when it is silent.

import type { StreamStateResponse } from '../gen/treeline/v1/navigation_pb.js';
import { eventOf, sceneOf, stateOf } from './from_proto.js';
import type { RobotEvent, RobotScene, RobotState } from './types.js';

export type Link = 'connecting' | 'live' | 'lost';

export interface StreamListener {
  state(state: RobotState): void;
  scene(scene: RobotScene): void;
  event(event: RobotEvent): void;
  // `retryInMs`: when the next attempt begins, if lost.
  link(link: Link, retryInMs: number): void;
  // A message made no sense.
  garbled(error: Error): void;
}

export interface StreamTools {
  // NavigationService.StreamState, until `signal`.
  watch(signal: AbortSignal): AsyncIterable<StreamStateResponse>;
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
  private call: AbortController | null = null;
  private timer = 0;
  private failures = 0;
  private current: Link = 'connecting';

  constructor(
      private readonly tools: StreamTools,
      private readonly listener: StreamListener) {}

  get link(): Link {
    return this.current;
  }

  start(): void {
    this.connect();
  }

  stop(): void {
    this.tools.forget(this.timer);
    this.call?.abort();
    this.call = null;
  }

  // Now rather than when the next attempt is due: the network is back, or
  // somebody looks at the page again.
  retryNow(): void {
    if (this.current === 'lost') this.connect();
  }

  private connect(): void {
    this.stop();
    this.call = new AbortController();
    this.timer = this.tools.later(() => this.lose(), PATIENCE_MS);
    void this.listen(this.call);
  }

  // Until the stream ends, whatever ends it, or another takes its place.
  private async listen(call: AbortController): Promise<void> {
    try {
      for await (const message of this.tools.watch(call.signal)) {
        if (this.call !== call) return;
        // One without a state says that there is nothing new.
        if (message.state !== undefined) this.hear(message);
      }
    } catch {
      // The agent has gone, or refuses: it is asked again later.
    }
    if (this.call === call) this.lose();
  }

  private hear({ state, scene, events }: StreamStateResponse): void {
    this.heard();
    if (state !== undefined) {
      this.tell(() => this.listener.state(stateOf(state)));
    }
    if (scene !== undefined) {
      this.tell(() => this.listener.scene(sceneOf(scene)));
    }
    for (const event of events) {
      this.tell(() => this.listener.event(eventOf(event)));
    }
  }

  private tell(work: () => void): void {
    try {
      work();
    } catch (error) {
      this.listener.garbled(
          error instanceof Error ? error : new Error(String(error)));
    }
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
