// The perfect OctoMap of a synthetic world.
#ifndef NAV_AGENT_APP_LOCALIZE_WORLD_H_
#define NAV_AGENT_APP_LOCALIZE_WORLD_H_

#include "absl/status/statusor.h"
#include "common/synthetic/world.h"
#include "nav_agent/octomap/voxel_map.h"

namespace treeline {

// Occupied is every voxel that a surface passes through; level surfaces on a
// border between two are in the lower one. Free is what can be got to from the
// world's tour. Glass, which lasers look through, and bodies, which
// move, are not occupied; the former bounds what is free. INVALID_ARGUMENT for
// worlds without surfaces or without a tour, and for what VoxelMap::Make
// refuses.
absl::StatusOr<VoxelMap> VoxelsOfWorld(const World& world, double resolution_m);

}  // namespace treeline

#endif  // NAV_AGENT_APP_LOCALIZE_WORLD_H_
