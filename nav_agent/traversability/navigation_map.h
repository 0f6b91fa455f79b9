// Levels as planning and control ask them: what ground is here, and how far is
// it from there to what a robot must not touch.
#ifndef NAV_AGENT_TRAVERSABILITY_NAVIGATION_MAP_H_
#define NAV_AGENT_TRAVERSABILITY_NAVIGATION_MAP_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/traversability/traversability.h"

namespace treeline::traversability {

struct NavigationMapOptions {
  // Distances are exact up to here (m, 0.1 to 100).
  double reach_m = 3.0;
  // Ground continues other ground if it differs by at most this in height (m,
  // above 0).
  double max_rise_m = 0.3;
  // Whether unknown cells are free to drive on.
  bool allow_unknown = false;

  absl::Status Validate() const;
};

// Immutable and thread-safe. The map's frame throughout.
class NavigationMap {
 public:
  // Low ends of ramps' sides (RampSideEdges) become occupied.
  // INVALID_ARGUMENT for bad options, no levels, or none with a free cell.
  static absl::StatusOr<NavigationMap> Make(
      TraversableMap map, const NavigationMapOptions& options = {});

  const TraversableMap& traversable() const { return map_; }
  const NavigationMapOptions& options() const { return options_; }
  int levels() const { return static_cast<int>(map_.levels.size()); }
  const core::OccupancyGrid& grid(int level) const {
    return map_.levels[static_cast<size_t>(level)].grid;
  }
  double resolution_m() const { return grid(0).resolution_m; }

  // Whether a robot's wheel may be there.
  bool IsFree(int level, core::CellIndex cell) const;
  // From the cell's centre to the centre of the nearest cell of its level that
  // is not free (obstacle, unknown unless allowed, outside), at most reach_m;
  // 0 in such cells. A neighbouring level's ground, where a ramp goes over to
  // it, is free as far as 1.5 m beyond; not what lies above or below.
  float ClearanceAt_m(int level, core::CellIndex cell) const;
  // The same at a point, between centres by bilinear interpolation.
  double Clearance_m(int level, geometry::Vec2 point_in_map) const;

  // The ground at `point` that continues ground at height_m: of the level
  // whose height is nearest, free ground first. So what moves over a join goes
  // over to the other level. nullopt where none is near.
  std::optional<core::LevelPlace> GroundNear(geometry::Vec2 point_in_map,
                                             double height_m) const;
  // That of one level; its surface is half a voxel above height_m's layer.
  std::optional<core::LevelPlace> GroundOf(geometry::Vec2 point_in_map,
                                           int level) const;
  // Eq. 6.2's angle, 0 where there is no ground (rad).
  double SlopeAt_rad(int level, geometry::Vec2 point_in_map) const;

 private:
  NavigationMap(TraversableMap map, const NavigationMapOptions& options);
  // Marks the ground of `other` that continues that of `level`, near it.
  void AddGroundBeyond(int level, int other,
                       std::vector<uint8_t>& is_free) const;

  TraversableMap map_;
  NavigationMapOptions options_;
  // One a level and cell.
  std::vector<std::vector<float>> clearance_m_;
};

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_NAVIGATION_MAP_H_
