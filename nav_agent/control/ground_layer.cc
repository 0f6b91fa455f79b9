#include "nav_agent/control/ground_layer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/core/distance_field.h"

namespace treeline::control {

GroundLayer::GroundLayer(
    std::shared_ptr<const traversability::NavigationMap> map, size_t cells)
    : map_(std::move(map)), ground_(cells), map_distance_m_(cells, 0.0F) {
  const geometry::Rigid2& map_from_grid = map_->grid(0).map_from_grid;
  map_cos_ = std::cos(map_from_grid.yaw_rad);
  map_sin_ = std::sin(map_from_grid.yaw_rad);
  map_origin_ = map_from_grid.translation;
}

std::optional<core::LevelPlace> GroundLayer::PlaceAt(size_t i) const {
  if (!IsGround(i)) return std::nullopt;
  return core::LevelPlace{.level = ground_[i].level,
                          .height_m = ground_[i].height_m};
}

double GroundLayer::HeightNear_m(const CostmapWindow& window,
                                 core::CellIndex cell) const {
  const size_t i = window.IndexOf(cell.x, cell.y);
  if (IsGround(i)) return Height_m(i);
  double height_m = robot_height_m_;
  for (int y = cell.y - 1; y <= cell.y + 1; ++y) {
    for (int x = cell.x - 1; x <= cell.x + 1; ++x) {
      if (window.IsInside(x, y) && IsGround(window.IndexOf(x, y))) {
        height_m = Height_m(window.IndexOf(x, y));
      }
    }
  }
  return height_m;
}

bool GroundLayer::IsHeightOfObstacle(const CostmapWindow& window,
                                     core::CellIndex cell, double z_m,
                                     double range_m,
                                     double robot_height_m) const {
  const double tolerance_m = kGroundTolerance_m + kGroundPerRange * range_m;
  if (!window.IsInside(cell)) return false;
  const double ground_m = HeightNear_m(window, cell);
  return z_m > ground_m + tolerance_m && z_m < ground_m + robot_height_m;
}

bool GroundLayer::IsNearMap(size_t i) const {
  return MapDistance_m(i) <= kMapBand_m;
}

bool GroundLayer::IsEdgeOfGround(const CostmapWindow& window, int x,
                                 int y) const {
  const size_t i = window.IndexOf(x, y);
  const auto row = static_cast<size_t>(window.width());
  return (x > 0 && IsGround(i - 1)) ||
         (x + 1 < window.width() && IsGround(i + 1)) ||
         (y > 0 && IsGround(i - row)) ||
         (y + 1 < window.height() && IsGround(i + row));
}

core::CellIndex GroundLayer::MapCellAt(geometry::Vec2 point_in_map) const {
  const geometry::Vec2 from_origin = point_in_map - map_origin_;
  const double scale = 1 / map_->resolution_m();
  return {static_cast<int>(std::floor(
              scale * (map_cos_ * from_origin.x + map_sin_ * from_origin.y))),
          static_cast<int>(std::floor(
              scale * (-map_sin_ * from_origin.x + map_cos_ * from_origin.y)))};
}

bool GroundLayer::SetFreed(
    std::shared_ptr<const traversability::FreedCells> freed) {
  if (freed == freed_) return false;
  freed_ = std::move(freed);
  return true;
}

// NaN: ground that is not known and may be driven on.
std::optional<float> GroundLayer::FreeGround_m(int level,
                                               core::CellIndex map_cell) const {
  if (map_->IsFree(level, map_cell)) {
    const traversability::TraversableLevel& of =
        map_->traversable().levels[static_cast<size_t>(level)];
    return of.height_m[of.grid.IndexOf(map_cell)] +
           static_cast<float>(0.5 * map_->resolution_m());
  }
  return freed_ == nullptr ? std::nullopt : freed_->Ground_m(level, map_cell);
}

std::optional<GroundLayer::Ground> GroundLayer::StepOnto(
    core::CellIndex map_cell, const Ground& from) const {
  std::optional<Ground> best;
  double best_m = kStepVoxels * map_->resolution_m();
  if (!map_->grid(0).Contains(map_cell)) return best;
  for (int level = 0; level < map_->levels(); ++level) {
    const std::optional<float> ground_m = FreeGround_m(level, map_cell);
    if (!ground_m.has_value()) continue;
    float height_m = *ground_m;
    // Unknown ground that may be driven on goes on level.
    if (std::isnan(height_m)) {
      if (level != from.level) continue;
      height_m = from.height_m;
    }
    // The robot's own level, if both would do.
    const double off_m =
        std::abs(height_m - from.height_m) + (level == from.level ? 0 : 1e-3);
    if (off_m > best_m) continue;
    best_m = off_m;
    best = Ground{.level = level, .height_m = height_m};
  }
  return best;
}

bool GroundLayer::Seed(const CostmapWindow& window, const core::LevelPose& pose,
                       std::vector<int>& open) {
  const double reach_cells = kSeedReach_m / window.resolution_m();
  const core::CellIndex at = window.CellOf(pose.map_from_base.translation);
  const int reach = static_cast<int>(reach_cells);
  double best = std::numeric_limits<double>::infinity();
  core::CellIndex best_cell;
  std::optional<Ground> best_ground;
  for (int y = at.y - reach; y <= at.y + reach; ++y) {
    for (int x = at.x - reach; x <= at.x + reach; ++x) {
      const double cells = std::hypot(x - at.x, y - at.y);
      if (!window.IsInside(x, y) || cells >= best || cells > reach_cells) {
        continue;
      }
      const core::CellIndex map_cell = MapCellAt(window.CenterInMap(x, y));
      for (const double off_m : kSeedHeights_m.value) {
        const Ground from = {
            .level = pose.place.level,
            .height_m = static_cast<float>(pose.place.height_m + off_m)};
        const std::optional<Ground> ground = StepOnto(map_cell, from);
        if (!ground.has_value()) continue;
        best = cells;
        best_cell = {x, y};
        best_ground = ground;
        break;
      }
    }
  }
  if (!best_ground.has_value()) return false;
  const size_t i = window.IndexOf(best_cell.x, best_cell.y);
  ground_[i] = *best_ground;
  open.push_back(static_cast<int>(i));
  return true;
}

void GroundLayer::Spread(const CostmapWindow& window,
                         const core::LevelPose& pose) {
  map_is_unknown_ = false;
  robot_height_m_ = pose.place.height_m;
  ground_.assign(window.cells(), Ground());
  std::vector<int> open;
  open.reserve(ground_.size());
  if (Seed(window, pose, open)) {
    for (size_t next = 0; next < open.size(); ++next) {
      const int i = open[next];
      const int cell_x = i % window.width();
      const int cell_y = i / window.width();
      const Ground from = ground_[static_cast<size_t>(i)];
      for (int y = cell_y - 1; y <= cell_y + 1; ++y) {
        for (int x = cell_x - 1; x <= cell_x + 1; ++x) {
          if (!window.IsInside(x, y)) continue;
          const size_t to = window.IndexOf(x, y);
          if (IsGround(to)) continue;
          const std::optional<Ground> ground =
              StepOnto(MapCellAt(window.CenterInMap(x, y)), from);
          if (!ground.has_value()) continue;
          ground_[to] = *ground;
          open.push_back(static_cast<int>(to));
        }
      }
    }
  }
  MeasureDistances(window);
}

void GroundLayer::SpreadLevel(const CostmapWindow& window,
                              const core::LevelPose& pose,
                              geometry::Vec2 rise) {
  map_is_unknown_ = true;
  robot_height_m_ = pose.place.height_m;
  ground_.resize(window.cells());
  const geometry::Vec2 at = pose.map_from_base.translation;
  for (int y = 0; y < window.height(); ++y) {
    for (int x = 0; x < window.width(); ++x) {
      const geometry::Vec2 off = window.CenterInMap(x, y) - at;
      // Downhill, the slope may end at any place.
      const double up_m = std::max(0.0, rise.x * off.x + rise.y * off.y);
      ground_[window.IndexOf(x, y)] = {
          .level = 0,
          .height_m = static_cast<float>(pose.place.height_m + up_m)};
    }
  }
  MeasureDistances(window);
}

void GroundLayer::MeasureDistances(const CostmapWindow& window) {
  std::vector<uint8_t> is_obstacle(ground_.size());
  for (size_t i = 0; i < ground_.size(); ++i) {
    is_obstacle[i] = IsGround(i) ? 0 : 1;
  }
  const std::vector<int32_t> squared =
      core::SquaredDistances(window.width(), window.height(), is_obstacle);
  map_distance_m_.resize(squared.size());
  for (size_t i = 0; i < squared.size(); ++i) {
    map_distance_m_[i] =
        squared[i] == core::kNoObstacle
            ? std::numeric_limits<float>::infinity()
            : static_cast<float>(window.resolution_m() *
                                 std::sqrt(static_cast<double>(squared[i])));
  }
}

std::vector<geometry::Vec2> GroundLayer::MapObstacles(
    const core::LevelPose& pose, double radius_m) const {
  std::vector<geometry::Vec2> obstacles;
  const geometry::Vec2 at = pose.map_from_base.translation;
  const Ground ground = {.level = pose.place.level,
                         .height_m = static_cast<float>(pose.place.height_m)};
  const auto is_ground = [&](int x, int y) {
    return StepOnto({x, y}, ground).has_value();
  };
  const core::CellIndex middle = MapCellAt(at);
  const int reach = static_cast<int>(radius_m / map_->resolution_m()) + 1;
  for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
    for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
      const geometry::Vec2 center = map_->grid(0).CenterInMap({x, y});
      if (geometry::Norm(center - at) > radius_m || is_ground(x, y)) continue;
      if (is_ground(x - 1, y) || is_ground(x + 1, y) || is_ground(x, y - 1) ||
          is_ground(x, y + 1)) {
        obstacles.push_back(center);
      }
    }
  }
  return obstacles;
}

}  // namespace treeline::control
