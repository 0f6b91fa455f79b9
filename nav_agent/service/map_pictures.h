// The map as browsers take it.
#ifndef NAV_AGENT_SERVICE_MAP_PICTURES_H_
#define NAV_AGENT_SERVICE_MAP_PICTURES_H_

#include <string>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::agent_service {

// PNG, a pixel for each cell, row 0 at the top (+y of the grid): free is white,
// occupied black, unknown grey.
absl::StatusOr<std::string> LevelPng(const core::OccupancyGrid& grid);

// "TLVH", uint32 width, uint32 height, then a float32 for each cell, rows from
// the bottom as the grid has them: how high the ground's surface is in the map
// (m), as poses have it; a quiet NaN where the level has no ground.
// Little-endian.
std::string LevelHeights(const traversability::TraversableLevel& level);

// "TLVX", uint32 count, float32 resolution_m, then count times the centre of an
// occupied voxel in the map (3 float32, m). Little-endian. Voxels that are
// enclosed on six sides are left out: nobody sees them.
std::string OctomapBytes(const octree::VoxelMap& voxels,
                         const geometry::Rigid2& map_from_voxels = {});

// Where the frame of a map's voxels lies: columns are the levels' cells, which
// may be turned (LaserLevelMap::Make).
geometry::Rigid2 MapFromVoxels(const octree::VoxelMap& voxels,
                               const traversability::TraversableMap& levels);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_MAP_PICTURES_H_
