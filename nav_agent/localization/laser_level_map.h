// What a laser sees in a building with slopes and several levels, and where in
// it a robot can be: made from an OctoMap and the levels found in it.
#ifndef NAV_AGENT_LOCALIZATION_LASER_LEVEL_MAP_H_
#define NAV_AGENT_LOCALIZATION_LASER_LEVEL_MAP_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/vector3.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/localization/likelihood_field.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/octomap/voxel_map.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::localization {

struct LaserLevelOptions {
  // Heights are told apart by layers this thick (m), in [0.02, 1]. A layer
  // holds what is occupied within a voxel of it too: an end point's height is
  // not known better.
  double layer_m = kLayer_m;
  // Of one field for all layers, in bytes.
  int64_t max_bytes = kMaxFieldBytes;
  // A robot goes from one ground to another if they differ by at most this in
  // height (m), in (0, 1].
  double max_rise_m = kMaxRise_m;
  LikelihoodFieldOptions field;

  // INVALID_ARGUMENT names the field.
  absl::Status Validate() const;
};

struct FreePlace {
  geometry::Vec2 center;
  core::LevelPlace place;
};

// A likelihood field for each height, rather than the traversable map's
// occupied cells, which a laser does not see: edges of slopes and drops,
// stairs. Immutable and thread-safe.
class LaserLevelMap {
 public:
  // The levels must be of these voxels. INVALID_ARGUMENT for bad options, other
  // resolutions, and levels without any free cell; RESOURCE_EXHAUSTED if it
  // took more than max_bytes.
  static absl::StatusOr<LaserLevelMap> Make(
      const octree::VoxelMap& voxels,
      const traversability::TraversableMap& traversable,
      const LaserLevelOptions& options = {});

  const LikelihoodField& field() const { return field_; }
  // Free cells of all levels. What two levels share counts once.
  const std::vector<FreePlace>& free_places() const { return free_places_; }
  double resolution_m() const { return resolution_m_; }
  int levels() const { return static_cast<int>(heights_m_.size()); }

  // The ground at `point` that continues ground at height_m: of the level whose
  // height is nearest, the lower one of two that share it. So a robot that
  // drives over a join goes over to the other level. nullopt where none is
  // near: in walls, and outside.
  std::optional<core::LevelPlace> GroundNear(geometry::Vec2 point,
                                             double height_m) const;
  // The ground of one level.
  std::optional<core::LevelPlace> GroundOf(geometry::Vec2 point,
                                           int level) const;
  // Whether a point lies within this of any level's ground.
  bool IsOnGround(geometry::Vec3 point, double tolerance_m) const;

 private:
  LaserLevelMap() = default;

  LikelihoodField field_ = LikelihoodField::Empty();
  std::vector<FreePlace> free_places_;
  double resolution_m_ = 0;
  double max_rise_m_ = 0;
  // Cells of all levels; its states are not used.
  core::OccupancyGrid cells_;
  // One a level and cell; NaN: no ground. Of the surface: half a voxel above
  // the middle of its voxel.
  std::vector<std::vector<float>> heights_m_;
};

// What a laser sees at laser_height_m above one level's ground, where that is
// level: occupied where a voxel is within one voxel of that height above the
// free ground nearest to a cell, else free where the level is, else unknown.
core::OccupancyGrid LaserSlice(const octree::VoxelMap& voxels,
                               const traversability::TraversableLevel& level,
                               double laser_height_m);

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_LASER_LEVEL_MAP_H_
