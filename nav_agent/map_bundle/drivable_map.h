// Maps of whatever kind, as a robot drives on them: one way in for all
// programs.
#ifndef NAV_AGENT_MAP_BUNDLE_DRIVABLE_MAP_H_
#define NAV_AGENT_MAP_BUNDLE_DRIVABLE_MAP_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::map_bundle {

struct DrivableMap {
  // A bundle's own, or how the file of a flat map is called, without `.yaml`.
  std::string name;
  // As localization::LaserLevelMap::Make takes both: voxels are in the frame of
  // the map, or, of flat maps, in that of the cells.
  octree::VoxelMap voxels;
  traversability::TraversableMap levels;
  // What whoever drives on it may not have meant, for people; empty: nothing.
  std::string warning;
};

// Whether this is what a map of map_server is named by: its YAML file.
bool IsFlatMapName(absl::string_view path);

// A map bundle's folder (LoadMapBundle), or the YAML of a map of map_server
// (core::ReadMap). The latter is one flat level at height 0, whose walls all
// lasers see: its voxels are one layer, in the frame of its cells, so that its
// origin may be anywhere and turned. Errors say what to give instead;
// INVALID_ARGUMENT for a flat map without a free cell.
absl::StatusOr<DrivableMap> LoadDrivableMap(const std::string& path);

}  // namespace treeline::map_bundle

#endif  // NAV_AGENT_MAP_BUNDLE_DRIVABLE_MAP_H_
