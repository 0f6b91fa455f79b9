// Driving by hand: what a pad or keys say, sent again and again while somebody
// holds them. The robot stands when nothing comes.

export interface Velocity {
  forward: number;
  yawRate: number;
}

// At the pad's edge. The robot's own limits are the agent's to keep.
export const FASTEST_MPS = 0.5;
export const FASTEST_RADPS = 0.9;
// A touch near the middle is no wish to move.
const REST = 0.12;
// Well below the 0.3 s that a command is good for.
export const PERIOD_MS = 100;
// Commands whose answers are awaited: on a slow line, no more are sent.
const MOST_AWAITED = 3;

const clamp = (value: number): number => Math.max(-1, Math.min(1, value));

// right, up: of a pad's middle, 1 at its edges.
export function velocityOf(right: number, up: number): Velocity {
  const reach = Math.hypot(right, up);
  if (!Number.isFinite(reach) || reach < REST) {
    return { forward: 0, yawRate: 0 };
  }
  const share = (Math.min(1, reach) - REST) / (1 - REST) / reach;
  return {
    forward: clamp(up * share) * FASTEST_MPS,
    yawRate: -clamp(right * share) * FASTEST_RADPS || 0,
  };
}

const KEYS: Record<string, [right: number, up: number]> = {
  arrowup: [0, 1], w: [0, 1], arrowdown: [0, -1], s: [0, -1],
  arrowleft: [-1, 0], a: [-1, 0], arrowright: [1, 0], d: [1, 0],
};

export function isDrivingKey(key: string): boolean {
  return key.toLowerCase() in KEYS;
}

// Of keys that are held: half as fast as the pad can.
export function velocityOfKeys(keys: Iterable<string>): Velocity {
  let [right, up] = [0, 0];
  for (const key of keys) {
    const [x, y] = KEYS[key.toLowerCase()] ?? [0, 0];
    right += x;
    up += y;
  }
  return {
    forward: 0.5 * clamp(up) * FASTEST_MPS,
    yawRate: -0.5 * clamp(right) * FASTEST_RADPS || 0,
  };
}

export interface HandDriveWorld {
  send(velocity: Velocity, sequence: bigint): Promise<void>;
  // Calls `work` every PERIOD_MS until what it gives is called.
  every(work: () => void): () => void;
  // Whether a command that failed is no more than that one: late, or overtaken.
  isPassing(error: unknown): boolean;
  // The agent refused: once while it is held.
  refused(error: unknown): void;
  moves(isDriven: boolean): void;
}

export class HandDrive {
  private velocity: Velocity = { forward: 0, yawRate: 0 };
  private stopClock: (() => void) | null = null;
  private awaited = 0;

  // sequence: higher than all of this driver before.
  constructor(
      private readonly world: HandDriveWorld, private sequence = 0n) {}

  get isDriven(): boolean {
    return this.stopClock !== null;
  }

  hold(velocity: Velocity): void {
    this.velocity = velocity;
    if (this.stopClock !== null) return;
    this.stopClock = this.world.every(() => this.say());
    this.world.moves(true);
    this.say();
  }

  // Stands at once, not only when the last command is stale.
  release(): void {
    if (this.stopClock === null) return;
    this.end();
    this.send({ forward: 0, yawRate: 0 });
  }

  private end(): void {
    this.stopClock?.();
    this.stopClock = null;
    this.world.moves(false);
  }

  private say(): void {
    if (this.awaited < MOST_AWAITED) this.send(this.velocity);
  }

  private send(velocity: Velocity): void {
    ++this.awaited;
    this.world.send(velocity, ++this.sequence)
        .catch((error: unknown) => {
          if (!this.isDriven || this.world.isPassing(error)) return;
          this.end();
          this.world.refused(error);
        })
        .finally(() => --this.awaited);
  }
}
