// A zone that is being drawn, corner by corner.

import type { Zone, ZoneKind } from '../api/types.js';
import type { Place } from './gesture.js';

// What the agent takes.
export const MOST_CORNERS = 100;
export const SLOWEST_MPS = 0.05;
export const FASTEST_MPS = 5;
// A corner so near to the one before is a double click (m).
const SAME_M = 0.05;

export const KIND_LABELS: Record<ZoneKind, string> = {
  'keep-out': 'Keep out', 'speed': 'Slow', 'one-way': 'One way',
};

export class ZoneDraft {
  readonly corners: Place[] = [];
  private drawnOn = 0;

  get level(): number {
    return this.drawnOn;
  }

  // Whether it is a corner more. On another level it begins anew.
  add({ x, y }: Place, level: number): boolean {
    if (level !== this.drawnOn) this.clear();
    this.drawnOn = level;
    const last = this.corners.at(-1);
    const isSame = last !== undefined &&
        Math.hypot(last.x - x, last.y - y) < SAME_M;
    if (isSame || this.corners.length >= MOST_CORNERS) return false;
    this.corners.push({ x, y });
    return true;
  }

  undo(): void {
    this.corners.pop();
  }

  clear(): void {
    this.corners.length = 0;
  }

  get isZone(): boolean {
    return this.corners.length >= 3;
  }

  // One-way zones lead as their first side was drawn.
  zone(name: string, kind: ZoneKind, maxMps: number): Zone {
    const [a, b] = this.corners;
    return {
      name, kind, level: this.drawnOn,
      corners: this.corners.map(({ x, y }) => ({ x, y })),
      maxMps: kind === 'speed' ? maxMps : 0,
      direction: kind === 'one-way' ? Math.atan2(b.y - a.y, b.x - a.x) : 0,
    };
  }
}

// "Slow 2": the first such name that is free.
export function freeName(kind: ZoneKind, zones: readonly Zone[]): string {
  const names = new Set(zones.map(({ name }) => name));
  for (let i = 1; ; ++i) {
    const name = `${KIND_LABELS[kind]} ${i}`;
    if (!names.has(name)) return name;
  }
}

// What a zone says, for a list.
export function zoneDetail(zone: Zone, levels: number): string {
  const what = zone.kind === 'speed' ? `at most ${zone.maxMps} m/s` :
    KIND_LABELS[zone.kind].toLowerCase();
  return levels > 1 ? `${what}, level ${zone.level}` : what;
}
