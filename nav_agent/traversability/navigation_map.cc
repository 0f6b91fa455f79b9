#include "nav_agent/traversability/navigation_map.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/core/distance_field.h"
#include "nav_agent/traversability/ramp_edges.h"

namespace treeline::traversability {
namespace {

// As far as a robot's footprint reaches over a join, and there is room to tell.
constexpr double kBeyond_m = 1.5;

bool IsFreeValue(core::Occupancy value, bool allow_unknown) {
  return value == core::Occupancy::kFree ||
         (allow_unknown && value == core::Occupancy::kUnknown);
}

// Exact distances from each cell to what is not free, and to what lies outside:
// the grid with one more cell around it.
std::vector<float> Clearances(const core::OccupancyGrid& grid,
                              const std::vector<uint8_t>& is_free,
                              double reach_m) {
  const int width = grid.width + 2;
  const int height = grid.height + 2;
  std::vector<uint8_t> blocked(
      static_cast<size_t>(width) * static_cast<size_t>(height), 1);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      blocked[static_cast<size_t>(y + 1) * static_cast<size_t>(width) +
              static_cast<size_t>(x + 1)] =
          is_free[grid.IndexOf({x, y})] != 0 ? 0 : 1;
    }
  }
  const std::vector<int32_t> squared =
      core::SquaredDistances(width, height, blocked);
  std::vector<float> distances(grid.cells.size());
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const int32_t cells =
          squared[static_cast<size_t>(y + 1) * static_cast<size_t>(width) +
                  static_cast<size_t>(x + 1)];
      distances[grid.IndexOf({x, y})] = static_cast<float>(std::min(
          reach_m, grid.resolution_m * std::sqrt(static_cast<double>(cells))));
    }
  }
  return distances;
}

}  // namespace

absl::Status NavigationMapOptions::Validate() const {
  if (!(reach_m >= 0.1 && reach_m <= 100)) {
    return absl::InvalidArgumentError(
        absl::StrCat("reach_m must be in [0.1, 100], not ", reach_m));
  }
  if (!(max_rise_m > 0 && max_rise_m <= 10)) {
    return absl::InvalidArgumentError(
        absl::StrCat("max_rise_m must be in (0, 10], not ", max_rise_m));
  }
  return absl::OkStatus();
}

absl::StatusOr<NavigationMap> NavigationMap::Make(
    TraversableMap map, const NavigationMapOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  const bool has_free = std::ranges::any_of(
      map.levels, [&options](const TraversableLevel& level) {
        return std::ranges::any_of(
            level.grid.cells, [&options](core::Occupancy value) {
              return IsFreeValue(value, options.allow_unknown);
            });
      });
  if (!has_free) {
    return absl::InvalidArgumentError(
        "the map has no free ground: nothing on it can be driven on");
  }
  return NavigationMap(std::move(map), options);
}

NavigationMap::NavigationMap(TraversableMap map,
                             const NavigationMapOptions& options)
    : map_(std::move(map)), options_(options) {
  for (TraversableLevel& level : map_.levels) {
    const std::vector<uint8_t> edges = RampSideEdges(level);
    for (size_t i = 0; i < edges.size(); ++i) {
      if (edges[i] != 0) level.grid.cells[i] = core::Occupancy::kOccupied;
    }
  }
  for (int level = 0; level < levels(); ++level) {
    const core::OccupancyGrid& own = grid(level);
    std::vector<uint8_t> is_free(own.cells.size());
    for (size_t i = 0; i < is_free.size(); ++i) {
      is_free[i] = IsFreeValue(own.cells[i], options_.allow_unknown) ? 1 : 0;
    }
    for (const LevelJoin& join : map_.joins) {
      if (join.lower_level == level) {
        AddGroundBeyond(level, join.upper_level, is_free);
      } else if (join.upper_level == level) {
        AddGroundBeyond(level, join.lower_level, is_free);
      }
    }
    clearance_m_.push_back(Clearances(own, is_free, options_.reach_m));
  }
}

void NavigationMap::AddGroundBeyond(int level, int other,
                                    std::vector<uint8_t>& is_free) const {
  const core::OccupancyGrid& own = grid(level);
  const std::vector<float>& own_m =
      map_.levels[static_cast<size_t>(level)].height_m;
  const std::vector<float>& other_m =
      map_.levels[static_cast<size_t>(other)].height_m;
  const auto is_beyond = [&](core::CellIndex cell) {
    return own.Contains(cell) && own.At(cell) == core::Occupancy::kUnknown &&
           std::isnan(own_m[own.IndexOf(cell)]) && IsFree(other, cell);
  };
  // In rings: own ground first.
  std::vector<core::CellIndex> ring;
  for (int y = 0; y < own.height; ++y) {
    for (int x = 0; x < own.width; ++x) {
      if (IsFree(level, {x, y})) ring.push_back({x, y});
    }
  }
  const int rings = static_cast<int>(kBeyond_m / own.resolution_m);
  for (int i = 0; i < rings && !ring.empty(); ++i) {
    std::vector<core::CellIndex> next;
    for (const core::CellIndex& from : ring) {
      const float from_m =
          i == 0 ? own_m[own.IndexOf(from)] : other_m[own.IndexOf(from)];
      for (const core::CellIndex& to : {core::CellIndex{from.x + 1, from.y},
                                        core::CellIndex{from.x - 1, from.y},
                                        core::CellIndex{from.x, from.y + 1},
                                        core::CellIndex{from.x, from.y - 1}}) {
        if (!is_beyond(to) || is_free[own.IndexOf(to)] != 0) continue;
        // Also false for ground without a height.
        if (!(std::abs(other_m[own.IndexOf(to)] - from_m) <=
              options_.max_rise_m)) {
          continue;
        }
        is_free[own.IndexOf(to)] = 1;
        next.push_back(to);
      }
    }
    ring = std::move(next);
  }
}

bool NavigationMap::IsFree(int level, core::CellIndex cell) const {
  return grid(level).Contains(cell) &&
         IsFreeValue(grid(level).At(cell), options_.allow_unknown);
}

float NavigationMap::ClearanceAt_m(int level, core::CellIndex cell) const {
  if (!grid(level).Contains(cell)) return 0;
  return clearance_m_[static_cast<size_t>(level)][grid(level).IndexOf(cell)];
}

double NavigationMap::Clearance_m(int level,
                                  geometry::Vec2 point_in_map) const {
  const core::OccupancyGrid& own = grid(level);
  const geometry::Vec2 point = own.map_from_grid.Inverse() * point_in_map;
  const double x = point.x / own.resolution_m - 0.5;
  const double y = point.y / own.resolution_m - 0.5;
  if (!(std::abs(x) < 1e8 && std::abs(y) < 1e8)) return 0;
  const int left = static_cast<int>(std::floor(x));
  const int below = static_cast<int>(std::floor(y));
  const double right_part = x - left;
  const double above_part = y - below;
  return (1 - above_part) *
             ((1 - right_part) * ClearanceAt_m(level, {left, below}) +
              right_part * ClearanceAt_m(level, {left + 1, below})) +
         above_part *
             ((1 - right_part) * ClearanceAt_m(level, {left, below + 1}) +
              right_part * ClearanceAt_m(level, {left + 1, below + 1}));
}

std::optional<core::LevelPlace> NavigationMap::GroundOf(
    geometry::Vec2 point_in_map, int level) const {
  const core::CellIndex cell = grid(level).CellOf(point_in_map);
  if (!grid(level).Contains(cell)) return std::nullopt;
  const double height_m = map_.levels[static_cast<size_t>(level)]
                              .height_m[grid(level).IndexOf(cell)];
  if (std::isnan(height_m)) return std::nullopt;
  return core::LevelPlace{.level = level,
                          .height_m = height_m + resolution_m() / 2};
}

std::optional<core::LevelPlace> NavigationMap::GroundNear(
    geometry::Vec2 point_in_map, double height_m) const {
  std::optional<core::LevelPlace> nearest;
  double nearest_rise_m = options_.max_rise_m;
  bool nearest_is_free = false;
  for (int level = 0; level < levels(); ++level) {
    const std::optional<core::LevelPlace> place = GroundOf(point_in_map, level);
    if (!place.has_value()) continue;
    const double rise_m = std::abs(place->height_m - height_m);
    if (rise_m > options_.max_rise_m) continue;
    const bool is_free = IsFree(level, grid(level).CellOf(point_in_map));
    if (!nearest.has_value() || (is_free && !nearest_is_free) ||
        (is_free == nearest_is_free && rise_m < nearest_rise_m)) {
      nearest = place;
      nearest_rise_m = rise_m;
      nearest_is_free = is_free;
    }
  }
  return nearest;
}

double NavigationMap::SlopeAt_rad(int level,
                                  geometry::Vec2 point_in_map) const {
  const core::CellIndex cell = grid(level).CellOf(point_in_map);
  if (!grid(level).Contains(cell)) return 0;
  const float slope_rad = map_.levels[static_cast<size_t>(level)]
                              .slope_rad[grid(level).IndexOf(cell)];
  return std::isnan(slope_rad) ? 0 : slope_rad;
}

}  // namespace treeline::traversability
