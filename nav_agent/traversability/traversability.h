// From an OctoMap to maps of where a robot may drive (thesis 6.3.2).
#ifndef NAV_AGENT_TRAVERSABILITY_TRAVERSABILITY_H_
#define NAV_AGENT_TRAVERSABILITY_TRAVERSABILITY_H_

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/ground.h"
#include "nav_agent/traversability/traversability_options.h"

namespace treeline::traversability {

// One level: at most one ground in each cell. Layers have a value for each
// cell of the grid, in its order; NaN where the level has no ground.
struct TraversableLevel {
  core::OccupancyGrid grid;
  // The ground's height in the map: the middle of its highest voxel.
  std::vector<float> height_m;
  // Eq. 6.2's gradient, in [0, pi/2]; pi/2 at the edges of drops.
  std::vector<float> slope_rad;
  // Room above the ground; +infinity where nothing is above it.
  std::vector<float> clearance_m;
};

// Free cells that two levels share, side by side: where a ramp leads from one
// to the other.
struct LevelJoin {
  int lower_level = 0;
  int upper_level = 0;
  std::vector<core::CellIndex> cells;
};

// Levels from the bottom up; their grids cover the same cells.
struct TraversableMap {
  std::vector<TraversableLevel> levels;
  std::vector<LevelJoin> joins;
};

// Keeps the traversable map of an OctoMap that changes. The map after any
// updates is exactly what a new extraction gives. Not thread-safe.
class TraversabilityMapper {
 public:
  static absl::StatusOr<TraversabilityMapper> Make(
      const TraversabilityOptions& options);

  // Of all of `voxels`. INVALID_ARGUMENT if no voxel is occupied.
  absl::Status Rebuild(const octree::VoxelMap& voxels);
  // After only columns of `changed` have changed since the last call. Rebuilds
  // if the map's box, resolution, or whether it knows free space, changed.
  absl::Status Update(const octree::VoxelMap& voxels,
                      const ColumnRect& changed);

  const TraversableMap& map() const { return map_; }

 private:
  explicit TraversabilityMapper(const TraversabilityOptions& options)
      : options_(options) {}

  TraversabilityOptions options_;
  double resolution_m_ = 0;
  octree::VoxelIndex lowest_;
  octree::VoxelIndex size_;
  bool needs_sight_ = true;
  GroundColumns ground_;
  TraversableMap map_;
};

absl::StatusOr<TraversableMap> ExtractTraversableMap(
    const octree::VoxelMap& voxels, const TraversabilityOptions& options = {});

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_TRAVERSABILITY_H_
