// Which layer of a map of voxels a laser sees.
#ifndef NAV_AGENT_LOCALIZATION_LASER_LAYER_H_
#define NAV_AGENT_LOCALIZATION_LASER_LAYER_H_

#include <algorithm>
#include <cmath>

#include "nav_agent/octomap/voxel_map.h"

namespace treeline::localization {

// That of a laser at this height of the map (m), counted from the lowest one.
// Of what lies above or below all of them, the nearest, as LikelihoodField has
// it: a map that a plane has made is the same for all lasers.
inline int LaserLayer(const octree::VoxelMap& voxels, double laser_m) {
  const int z = static_cast<int>(std::floor(laser_m / voxels.resolution_m())) -
                voxels.lowest().z;
  return std::clamp(z, 0, std::max(voxels.size().z - 1, 0));
}

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_LASER_LAYER_H_
