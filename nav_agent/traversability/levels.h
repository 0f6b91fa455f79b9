// Ground -> levels.
#ifndef NAV_AGENT_TRAVERSABILITY_LEVELS_H_
#define NAV_AGENT_TRAVERSABILITY_LEVELS_H_

#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/ground.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline {

// `ground` is that of all columns of `voxels`.
TraversableMap MakeLevels(const VoxelMap& voxels, const GroundColumns& ground,
                          const TraversabilityOptions& options);

}  // namespace treeline

#endif  // NAV_AGENT_TRAVERSABILITY_LEVELS_H_
