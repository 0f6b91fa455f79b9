// The ground of a level: how high it is where, and where a line of sight meets
// it.

import type { LevelInfo } from '../api/types.js';

export interface Vec3 {
  x: number;
  y: number;
  z: number;
}

const MAGIC = 0x48564c54;  // "TLVH", little-endian
const HEADER_BYTES = 12;

// The answer of /api/levels/N.heights: "TLVH", uint32 width, uint32 height,
// then a float32 for each cell, rows from the bottom, NaN where there is no
// ground. Little-endian.
export function decodeHeights(
    bytes: ArrayBuffer, level: LevelInfo): Float32Array {
  const view = new DataView(bytes);
  if (bytes.byteLength < HEADER_BYTES || view.getUint32(0, true) !== MAGIC) {
    throw new Error('the level\'s heights do not begin with TLVH');
  }
  const width = view.getUint32(4, true);
  const height = view.getUint32(8, true);
  if (width !== level.width || height !== level.height ||
      bytes.byteLength !== HEADER_BYTES + 4 * width * height) {
    throw new Error(
        `the level's heights are ${width} x ${height} in ` +
        `${bytes.byteLength} bytes; ${level.width} x ${level.height} cells ` +
        'were expected');
  }
  const heights = new Float32Array(width * height);
  for (let i = 0; i < heights.length; ++i) {
    heights[i] = view.getFloat32(HEADER_BYTES + 4 * i, true);
  }
  return heights;
}

export class HeightField {
  // What is typical of the level (the median).
  readonly typical: number;
  readonly lowest: number;
  readonly highest: number;
  private readonly cosine: number;
  private readonly sine: number;

  // `heights`: null if they are not known; the level is flat then.
  constructor(
      readonly level: LevelInfo, readonly heights: Float32Array | null) {
    this.cosine = Math.cos(level.origin[2]);
    this.sine = Math.sin(level.origin[2]);
    const known = heights?.filter((height) => !Number.isNaN(height)).sort();
    if (known && known.length > 0) {
      this.lowest = known[0];
      this.highest = known[known.length - 1];
      this.typical = known[Math.floor(known.length / 2)];
    } else {
      this.lowest = this.highest = this.typical = level.minHeight;
    }
  }

  // The point of the map at (column, row) of the grid, which may be fractions:
  // (0, 0) is the grid's corner.
  toMap(column: number, row: number): { x: number; y: number } {
    const { resolution, origin } = this.level;
    const x = column * resolution;
    const y = row * resolution;
    return {
      x: origin[0] + this.cosine * x - this.sine * y,
      y: origin[1] + this.sine * x + this.cosine * y,
    };
  }

  private cellAt(x: number, y: number): number | null {
    const { resolution, origin, width, height } = this.level;
    const dx = x - origin[0];
    const dy = y - origin[1];
    const column =
        Math.floor((this.cosine * dx + this.sine * dy) / resolution);
    const row = Math.floor((this.cosine * dy - this.sine * dx) / resolution);
    const isInside =
        column >= 0 && row >= 0 && column < width && row < height;
    return isInside ? row * width + column : null;
  }

  // The ground's height; null where there is none.
  at(x: number, y: number): number | null {
    const cell = this.cellAt(x, y);
    if (cell === null) return null;
    if (this.heights === null) return this.typical;
    const height = this.heights[cell];
    return Number.isNaN(height) ? null : height;
  }

  atOr(x: number, y: number, other: number): number {
    return this.at(x, y) ?? other;
  }

  // Where the ray first meets the ground; beside the ground, the plane at its
  // typical height; null if it points away from that, too.
  pick(from: Vec3, along: Vec3): Vec3 | null {
    const point = (t: number): Vec3 => ({
      x: from.x + t * along.x,
      y: from.y + t * along.y,
      z: from.z + t * along.z,
    });
    if (along.z < -1e-6) {
      const begin = Math.max(0, (this.highest + 0.01 - from.z) / along.z);
      const end = (this.lowest - 0.01 - from.z) / along.z;
      const steps = this.stepsFor(along, end - begin);
      for (let i = 0; i <= steps; ++i) {
        const t = begin + ((end - begin) * i) / Math.max(1, steps);
        const here = point(t);
        const ground = this.at(here.x, here.y);
        if (ground !== null && here.z <= ground) {
          return { x: here.x, y: here.y, z: ground };
        }
      }
    }
    if (Math.abs(along.z) < 1e-6) return null;
    const t = (this.typical - from.z) / along.z;
    return t > 0 ? point(t) : null;
  }

  // So that no cell is stepped over.
  private stepsFor(along: Vec3, length: number): number {
    const across = Math.hypot(along.x, along.y) * Math.max(0, length);
    const down = Math.abs(along.z) * Math.max(0, length);
    return Math.min(
        20000, Math.ceil((across * 2) / this.level.resolution + down / 0.01));
  }
}
