// Fetches the map that an agent has.

import { ApiError, type AgentClient } from './api/client.js';
import type { AgentInfo } from './api/types.js';
import { decodeHeights, HeightField } from './model/height_field.js';
import { decodeOctomap } from './model/octomap.js';
import { meshOf, type VoxelMesh } from './model/voxel_mesh.js';

// The ground of all levels. An agent without heights has flat levels.
export async function loadFields(
    client: AgentClient, info: AgentInfo): Promise<HeightField[]> {
  return Promise.all(info.levels.map(async (level) => {
    try {
      const bytes = await client.bytes(`api/levels/${level.index}.heights`);
      return new HeightField(level, decodeHeights(bytes, level));
    } catch (error) {
      if (error instanceof ApiError && error.code === 'unreachable') {
        throw error;
      }
      return new HeightField(level, null);
    }
  }));
}

export async function loadLevelPicture(
    client: AgentClient, level: number): Promise<ImageBitmap> {
  return createImageBitmap(await client.picture(`api/levels/${level}.png`));
}

export async function loadVoxels(client: AgentClient): Promise<VoxelMesh> {
  return meshOf(decodeOctomap(await client.bytes('api/octomap')));
}
