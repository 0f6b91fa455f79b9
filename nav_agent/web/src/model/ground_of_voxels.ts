// The ground of a level, from the OctoMap, for agents that do not give it.

import type { LevelInfo } from '../api/types.js';
import type { Octomap } from './octomap.js';

// Less room above is no ground that a robot stands on (m).
const ROOM_M = 1.0;

// In each cell, the lowest surface between the level's heights with room above;
// NaN where there is none.
export function heightsFromVoxels(
    level: LevelInfo, { resolution, centres }: Octomap): Float32Array {
  const { width, height, origin } = level;
  const cosine = Math.cos(origin[2]);
  const sine = Math.sin(origin[2]);
  const columns: number[][] = Array.from({ length: width * height }, () => []);
  for (let i = 0; i < centres.length; i += 3) {
    const dx = centres[i] - origin[0];
    const dy = centres[i + 1] - origin[1];
    const column = Math.floor((cosine * dx + sine * dy) / level.resolution);
    const row = Math.floor((cosine * dy - sine * dx) / level.resolution);
    const isInside =
        column >= 0 && row >= 0 && column < width && row < height;
    if (isInside) columns[row * width + column].push(centres[i + 2]);
  }
  const low = level.minHeight - 0.6 * resolution;
  const high = level.maxHeight + 0.6 * resolution;
  return Float32Array.from(columns, (column) => {
    column.sort((a, b) => a - b);
    const at = column.findIndex((z, i) => z >= low && z <= high &&
        (i + 1 === column.length || column[i + 1] > z + ROOM_M));
    return at < 0 ? NaN : column[at] + resolution / 2;
  });
}
