// The perfect OctoMap of a synthetic world.
#ifndef SIMULATION_RUNS_LOCALIZE_WORLD_H_
#define SIMULATION_RUNS_LOCALIZE_WORLD_H_

#include "absl/status/statusor.h"
#include "nav_agent/octomap/voxel_map.h"
#include "simulation/worlds/world.h"

namespace treeline::runs {

// Occupied is every voxel that a surface passes through; level surfaces on a
// border between two are in the lower one. Free is what can be got to from the
// world's tour. Glass, which lasers look through, and bodies, which
// move, are not occupied; the former bounds what is free. INVALID_ARGUMENT for
// worlds without surfaces or without a tour, and for what VoxelMap::Make
// refuses.
absl::StatusOr<octree::VoxelMap> VoxelsOfWorld(const worlds::World& world,
                                               double resolution_m);

}  // namespace treeline::runs

#endif  // SIMULATION_RUNS_LOCALIZE_WORLD_H_
