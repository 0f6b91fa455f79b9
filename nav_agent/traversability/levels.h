// Ground -> levels.
#ifndef NAV_AGENT_TRAVERSABILITY_LEVELS_H_
#define NAV_AGENT_TRAVERSABILITY_LEVELS_H_

#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/ground.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::traversability {

// `ground` is that of all columns of `voxels`.
TraversableMap MakeLevels(const octree::VoxelMap& voxels,
                          const GroundColumns& ground,
                          const TraversabilityOptions& options);

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_LEVELS_H_
