// Fetches the map that an agent has.

import { ApiError, type AgentClient } from './api/client.js';
import type { AgentInfo } from './api/types.js';
import { heightsFromVoxels } from './model/ground_of_voxels.js';
import { decodeHeights, HeightField } from './model/height_field.js';
import { decodeOctomap, type Octomap } from './model/octomap.js';

// The ground of all levels: as the agent has it, else as the voxels show it.
export async function loadFields(
    client: AgentClient, info: AgentInfo, voxels: Octomap):
    Promise<HeightField[]> {
  return Promise.all(info.levels.map(async (level) => {
    try {
      const bytes = await client.bytes(`api/levels/${level.index}.heights`);
      return new HeightField(level, decodeHeights(bytes, level));
    } catch (error) {
      if (error instanceof ApiError && error.code === 'unreachable') {
        throw error;
      }
      return new HeightField(level, heightsFromVoxels(level, voxels));
    }
  }));
}

export async function loadLevelPicture(
    client: AgentClient, level: number): Promise<ImageBitmap> {
  return createImageBitmap(await client.picture(`api/levels/${level}.png`));
}

export async function loadVoxels(client: AgentClient): Promise<Octomap> {
  return decodeOctomap(await client.bytes('api/octomap'));
}
