#include "nav_agent/control/local_costmap.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/core/distance_field.h"

namespace treeline::control {
namespace {

// Ground goes on over so many voxels of height from cell to cell: slopes are
// stairs of one voxel.
constexpr double kStepVoxels = 1.5;
// A robot that is not quite on free ground stands on what is this near (m).
constexpr double kSeedReach_m = 0.5;
// What was looked at so recently is seen (ms).
constexpr int64_t kSeenNow_ms = 150;

std::pair<int, int> CellsFor(double length_m, double resolution_m) {
  const int cells = static_cast<int>(std::lround(length_m / resolution_m));
  return {cells, cells / 2};
}

}  // namespace

absl::Status LocalCostmapOptions::Validate() const {
  if (!(length_m >= 1 && length_m <= 20 && width_m >= 1 && width_m <= 20)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the costmap must measure 1 to 20 m along each axis, not ",
                     length_m, " x ", width_m));
  }
  if (!(resolution_m >= 0.01 && resolution_m <= 0.2)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the costmap's resolution_m must be in [0.01, 0.2], not ",
                     resolution_m));
  }
  if (!(hits_to_mark >= 1 && most_hits >= hits_to_mark && most_hits <= 100 &&
        miss_weight >= 1)) {
    return absl::InvalidArgumentError(
        "hits_to_mark must be in [1, most_hits], most_hits at most 100, "
        "miss_weight at least 1");
  }
  if (!(ground_m >= 0 && ground_per_range >= 0 && map_band_m >= 0 &&
        standing_after_s >= 0 && moving_memory_s > 0 && standing_memory_s > 0 &&
        depth_range_m > 0 && depth_columns >= 1)) {
    return absl::InvalidArgumentError(
        "the costmap's tolerances and times must not be negative");
  }
  return absl::OkStatus();
}

absl::StatusOr<LocalCostmap> LocalCostmap::Make(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const core::RobotLasers& lasers,
    const LocalCostmapOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(robot.Validate());
  if (map == nullptr) return absl::InvalidArgumentError("there is no map");
  for (const core::RangeSensorInfo& laser :
       {lasers.front, lasers.rear.value_or(lasers.front)}) {
    if (laser.beams < 1 || !(laser.range_max_m > laser.range_min_m)) {
      return absl::InvalidArgumentError(
          "a laser's beams and ranges are not known: it has not said them yet");
    }
  }
  return LocalCostmap(std::move(map), robot, lasers, options);
}

LocalCostmap::LocalCostmap(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const core::RobotLasers& lasers,
    const LocalCostmapOptions& options)
    : map_(std::move(map)),
      robot_(robot),
      options_(options),
      footprint_(Footprint::Of(robot)),
      edge_in_base_(footprint_.Edge(options.resolution_m)),
      area_in_base_(footprint_.Area(0.7 * options.resolution_m)) {
  width_ = CellsFor(options_.length_m, options_.resolution_m).first;
  height_ = CellsFor(options_.width_m, options_.resolution_m).first;
  const geometry::Rigid2& map_from_grid = map_->grid(0).map_from_grid;
  map_cos_ = std::cos(map_from_grid.yaw_rad);
  map_sin_ = std::sin(map_from_grid.yaw_rad);
  map_origin_ = map_from_grid.translation;
  lasers_[static_cast<size_t>(core::LaserMount::kFront)].info = lasers.front;
  lasers_[static_cast<size_t>(core::LaserMount::kRear)].info =
      lasers.rear.value_or(core::RangeSensorInfo());
  held_looks_ = lasers.rear.has_value() ? 1 : 0;
  for (Laser& laser : lasers_) {
    for (int beam = 0; beam < laser.info.beams; ++beam) {
      laser.beam_cos.push_back(std::cos(laser.info.AngleOf_rad(beam)));
      laser.beam_sin.push_back(std::sin(laser.info.AngleOf_rad(beam)));
    }
  }
  const size_t cells =
      static_cast<size_t>(width_) * static_cast<size_t>(height_);
  ground_.resize(cells);
  seen_.resize(cells);
  map_distance_m_.resize(cells, 0);
  cells_.resize(cells, LocalCell::kMapObstacle);
  distance_m_.resize(cells, 0);
  hit_in_.resize(cells, 0);
  passed_in_.resize(cells, 0);
}

core::CellIndex LocalCostmap::CellOf(geometry::Vec2 point_in_map) const {
  return {static_cast<int>(std::floor((point_in_map.x - origin_in_map_.x) /
                                      options_.resolution_m)),
          static_cast<int>(std::floor((point_in_map.y - origin_in_map_.y) /
                                      options_.resolution_m))};
}

core::CellIndex LocalCostmap::MapCellAt(geometry::Vec2 point_in_map) const {
  const geometry::Vec2 from_origin = point_in_map - map_origin_;
  const double scale = 1 / map_->resolution_m();
  return {static_cast<int>(std::floor(
              scale * (map_cos_ * from_origin.x + map_sin_ * from_origin.y))),
          static_cast<int>(std::floor(
              scale * (-map_sin_ * from_origin.x + map_cos_ * from_origin.y)))};
}

int64_t LocalCostmap::Milliseconds(base::MonotonicTime time) {
  if (!epoch_.has_value()) epoch_ = time;
  return std::chrono::duration_cast<std::chrono::milliseconds>(time - *epoch_)
      .count();
}

// ---- the map's layer ----

void LocalCostmap::MoveTo(const ControlPose& control_pose) {
  const core::LevelPose& pose = control_pose.pose;
  const geometry::Vec2 at = pose.map_from_base.translation;
  const double r = options_.resolution_m;
  const auto x = static_cast<int64_t>(std::llround(at.x / r)) - width_ / 2;
  const auto y = static_cast<int64_t>(std::llround(at.y / r)) - height_ / 2;
  if (control_pose.map_is_unknown != map_is_unknown_) is_placed_ = false;
  map_is_unknown_ = control_pose.map_is_unknown;
  const bool rolls = !is_placed_ || x != cell_x_ || y != cell_y_;
  const bool climbs =
      !is_placed_ || pose.place.level != placed_at_.place.level ||
      std::abs(pose.place.height_m - placed_at_.place.height_m) >
          0.4 * map_->resolution_m();
  if (!rolls && !climbs) return;
  if (!is_placed_) {
    std::ranges::fill(seen_, Seen());
  } else if (rolls) {
    const int64_t by_x = x - cell_x_;
    const int64_t by_y = y - cell_y_;
    if (std::abs(by_x) < width_ && std::abs(by_y) < height_) {
      Shift(static_cast<int>(by_x), static_cast<int>(by_y));
    } else {
      std::ranges::fill(seen_, Seen());
    }
  }
  cell_x_ = x;
  cell_y_ = y;
  origin_in_map_ = {static_cast<double>(x) * r, static_cast<double>(y) * r};
  is_placed_ = true;
  placed_at_ = pose;
  SpreadGround(pose);
}

void LocalCostmap::Shift(int by_x, int by_y) {
  std::vector<Seen> shifted(seen_.size());
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (IsInside(x + by_x, y + by_y)) {
        shifted[IndexOf(x, y)] = seen_[IndexOf(x + by_x, y + by_y)];
      }
    }
  }
  seen_ = std::move(shifted);
}

std::optional<LocalCostmap::Ground> LocalCostmap::StepOnto(
    core::CellIndex map_cell, const Ground& from) const {
  const double most_m = kStepVoxels * map_->resolution_m();
  std::optional<Ground> best;
  double best_m = most_m;
  if (!map_->grid(0).Contains(map_cell)) return best;
  const size_t i = map_->grid(0).IndexOf(map_cell);
  for (int level = 0; level < map_->levels(); ++level) {
    if (!map_->IsFree(level, map_cell)) continue;
    float height_m =
        map_->traversable().levels[static_cast<size_t>(level)].height_m[i] +
        static_cast<float>(0.5 * map_->resolution_m());
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

bool LocalCostmap::SeedGround(const core::LevelPose& pose,
                              std::vector<int>& open) {
  const double reach_cells = kSeedReach_m / options_.resolution_m;
  const core::CellIndex at = CellOf(pose.map_from_base.translation);
  const int reach = static_cast<int>(reach_cells);
  double best = std::numeric_limits<double>::infinity();
  core::CellIndex best_cell;
  std::optional<Ground> best_ground;
  for (int y = at.y - reach; y <= at.y + reach; ++y) {
    for (int x = at.x - reach; x <= at.x + reach; ++x) {
      const double cells = std::hypot(x - at.x, y - at.y);
      if (!IsInside(x, y) || cells >= best || cells > reach_cells) continue;
      // Estimates of height are a voxel off, and more on a slope.
      for (const double off_m : {0.0, 0.05, -0.05, 0.12, -0.12, 0.2, -0.2}) {
        const Ground from = {
            .level = pose.place.level,
            .height_m = static_cast<float>(pose.place.height_m + off_m)};
        const std::optional<Ground> ground = StepOnto(MapCellOf(x, y), from);
        if (!ground.has_value()) continue;
        best = cells;
        best_cell = {x, y};
        best_ground = ground;
        break;
      }
    }
  }
  if (!best_ground.has_value()) return false;
  const size_t i = IndexOf(best_cell.x, best_cell.y);
  ground_[i] = *best_ground;
  open.push_back(static_cast<int>(i));
  return true;
}

void LocalCostmap::SpreadGround(const core::LevelPose& pose) {
  std::ranges::fill(ground_, Ground());
  std::vector<int> open;
  open.reserve(ground_.size());
  if (map_is_unknown_) {
    std::ranges::fill(
        ground_, Ground{.level = 0,
                        .height_m = static_cast<float>(pose.place.height_m)});
  } else if (SeedGround(pose, open)) {
    for (size_t next = 0; next < open.size(); ++next) {
      const int i = open[next];
      const int cell_x = i % width_;
      const int cell_y = i / width_;
      const Ground from = ground_[static_cast<size_t>(i)];
      for (int y = cell_y - 1; y <= cell_y + 1; ++y) {
        for (int x = cell_x - 1; x <= cell_x + 1; ++x) {
          if (!IsInside(x, y) || ground_[IndexOf(x, y)].level >= 0) continue;
          const std::optional<Ground> ground = StepOnto(MapCellOf(x, y), from);
          if (!ground.has_value()) continue;
          ground_[IndexOf(x, y)] = *ground;
          open.push_back(static_cast<int>(IndexOf(x, y)));
        }
      }
    }
  }
  MeasureMapDistances();
}

void LocalCostmap::MeasureMapDistances() {
  std::vector<uint8_t> is_obstacle(ground_.size());
  for (size_t i = 0; i < ground_.size(); ++i) {
    is_obstacle[i] = ground_[i].level < 0 ? 1 : 0;
  }
  const std::vector<int32_t> squared =
      core::SquaredDistances(width_, height_, is_obstacle);
  for (size_t i = 0; i < squared.size(); ++i) {
    map_distance_m_[i] =
        squared[i] == core::kNoObstacle
            ? std::numeric_limits<float>::infinity()
            : static_cast<float>(options_.resolution_m *
                                 std::sqrt(static_cast<double>(squared[i])));
  }
}

// ---- questions ----

bool LocalCostmap::Contains(geometry::Vec2 point_in_map, double inset_m) const {
  const geometry::Vec2 from = point_in_map - origin_in_map_;
  return from.x >= inset_m && from.y >= inset_m &&
         from.x < width_ * options_.resolution_m - inset_m &&
         from.y < height_ * options_.resolution_m - inset_m;
}

LocalCell LocalCostmap::CellAt(geometry::Vec2 point_in_map) const {
  const core::CellIndex cell = CellOf(point_in_map);
  return IsInside(cell.x, cell.y) ? At(cell.x, cell.y)
                                  : LocalCell::kMapObstacle;
}

double LocalCostmap::Distance_m(geometry::Vec2 point_in_map) const {
  const double r = options_.resolution_m;
  const double x = (point_in_map.x - origin_in_map_.x) / r - 0.5;
  const double y = (point_in_map.y - origin_in_map_.y) / r - 0.5;
  if (!(x >= -0.5 && y >= -0.5 && x <= width_ - 0.5 && y <= height_ - 0.5)) {
    return -r;
  }
  const int left = std::clamp(static_cast<int>(x), 0, width_ - 2);
  const int below = std::clamp(static_cast<int>(y), 0, height_ - 2);
  const double right_part = std::clamp(x - left, 0.0, 1.0);
  const double above_part = std::clamp(y - below, 0.0, 1.0);
  const size_t i = IndexOf(left, below);
  const size_t row = static_cast<size_t>(width_);
  const double lower =
      (1 - right_part) * distance_m_[i] + right_part * distance_m_[i + 1];
  const double upper = (1 - right_part) * distance_m_[i + row] +
                       right_part * distance_m_[i + row + 1];
  return (1 - above_part) * lower + above_part * upper - 0.5 * r;
}

geometry::Vec2 LocalCostmap::Away(geometry::Vec2 point_in_map) const {
  const double r = options_.resolution_m;
  const geometry::Vec2 gradient = {
      Distance_m({point_in_map.x + r, point_in_map.y}) -
          Distance_m({point_in_map.x - r, point_in_map.y}),
      Distance_m({point_in_map.x, point_in_map.y + r}) -
          Distance_m({point_in_map.x, point_in_map.y - r})};
  const double length = geometry::Norm(gradient);
  return length < 1e-6 ? geometry::Vec2{} : (1 / length) * gradient;
}

double LocalCostmap::FootprintDistance_m(const geometry::Rigid2& map_from_base,
                                         double at_most_m) const {
  const double from_center_m = Distance_m(map_from_base.translation);
  const double circumradius_m = footprint_.Circumradius_m();
  if (from_center_m > circumradius_m + at_most_m) return at_most_m;
  const double c = std::cos(map_from_base.yaw_rad);
  const double s = std::sin(map_from_base.yaw_rad);
  const geometry::Vec2 at = map_from_base.translation;
  const auto in_map = [&](geometry::Vec2 p) {
    return geometry::Vec2{at.x + c * p.x - s * p.y, at.y + s * p.x + c * p.y};
  };
  double least_m = at_most_m;
  for (const geometry::Vec2& point : edge_in_base_) {
    least_m = std::min(least_m, Distance_m(in_map(point)));
  }
  // Something small may stand within.
  if (least_m > 0 && from_center_m < circumradius_m) {
    for (const geometry::Vec2& point : area_in_base_) {
      const core::CellIndex cell = CellOf(in_map(point));
      if (!IsInside(cell.x, cell.y) ||
          distance_m_[IndexOf(cell.x, cell.y)] <= 0) {
        return std::min(-options_.resolution_m,
                        -footprint_.Inradius_m() + from_center_m);
      }
    }
  }
  return least_m;
}

std::optional<core::LevelPlace> LocalCostmap::GroundAt(
    geometry::Vec2 point_in_map) const {
  const core::CellIndex cell = CellOf(point_in_map);
  if (!IsInside(cell.x, cell.y)) return std::nullopt;
  const Ground& ground = ground_[IndexOf(cell.x, cell.y)];
  if (ground.level < 0) return std::nullopt;
  return core::LevelPlace{.level = ground.level, .height_m = ground.height_m};
}

std::vector<UnseenObstacle> LocalCostmap::UnseenObstacles(
    geometry::Vec2 at, double radius_m, base::MonotonicTime now) const {
  std::vector<UnseenObstacle> unseen;
  if (!epoch_.has_value()) return unseen;
  const int64_t now_ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(now - *epoch_)
          .count();
  const core::CellIndex middle = CellOf(at);
  const int reach = static_cast<int>(radius_m / options_.resolution_m) + 1;
  for (int y = std::max(0, middle.y - reach);
       y <= std::min(height_ - 1, middle.y + reach); ++y) {
    for (int x = std::max(0, middle.x - reach);
         x <= std::min(width_ - 1, middle.x + reach); ++x) {
      const size_t i = IndexOf(x, y);
      if (cells_[i] == LocalCell::kFree) continue;
      const geometry::Vec2 center = CenterInMap(x, y);
      if (geometry::Norm(center - at) > radius_m) continue;
      if (cells_[i] == LocalCell::kSeen) {
        const Seen& seen = seen_[i];
        if (now_ms - seen.last_ms <= kSeenNow_ms) continue;
        unseen.push_back({.in_map = center, .is_new = IsNew(i)});
        continue;
      }
      const bool is_edge =
          (x > 0 && ground_[i - 1].level >= 0) ||
          (x + 1 < width_ && ground_[i + 1].level >= 0) ||
          (y > 0 && ground_[i - static_cast<size_t>(width_)].level >= 0) ||
          (y + 1 < height_ &&
           ground_[i + static_cast<size_t>(width_)].level >= 0);
      if (is_edge) unseen.push_back({.in_map = center});
    }
  }
  return unseen;
}

std::vector<geometry::Vec2> LocalCostmap::MapObstacles(
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

SeenObstacle LocalCostmap::ObstacleNear(geometry::Vec2 point_in_map,
                                        double reach_m,
                                        base::MonotonicTime now) const {
  SeenObstacle obstacle;
  if (!epoch_.has_value()) return obstacle;
  // The nearest seen cell.
  double best_m = reach_m;
  std::optional<core::CellIndex> seed;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (At(x, y) != LocalCell::kSeen) continue;
      const double away_m = geometry::Norm(CenterInMap(x, y) - point_in_map);
      if (away_m < best_m) {
        best_m = away_m;
        seed = core::CellIndex{x, y};
      }
    }
  }
  if (!seed.has_value()) return obstacle;
  // What hangs together with it, gaps of a cell included.
  constexpr int kGap = 2;
  std::vector<uint8_t> is_known(cells_.size(), 0);
  std::vector<core::CellIndex> cells = {*seed};
  is_known[IndexOf(seed->x, seed->y)] = 1;
  for (size_t next = 0; next < cells.size(); ++next) {
    const core::CellIndex at = cells[next];
    for (int y = at.y - kGap; y <= at.y + kGap; ++y) {
      for (int x = at.x - kGap; x <= at.x + kGap; ++x) {
        if (!IsInside(x, y) || At(x, y) != LocalCell::kSeen ||
            is_known[IndexOf(x, y)] != 0) {
          continue;
        }
        is_known[IndexOf(x, y)] = 1;
        cells.push_back({x, y});
      }
    }
  }
  const int64_t now_ms =
      std::chrono::duration_cast<std::chrono::milliseconds>(now - *epoch_)
          .count();
  std::vector<int64_t> ages_ms;
  for (const core::CellIndex& cell : cells) {
    obstacle.center_in_map =
        obstacle.center_in_map +
        (1.0 / static_cast<double>(cells.size())) * CenterInMap(cell.x, cell.y);
    ages_ms.push_back(now_ms - seen_[IndexOf(cell.x, cell.y)].since_ms);
  }
  for (const core::CellIndex& cell : cells) {
    obstacle.radius_m = std::max(
        obstacle.radius_m,
        geometry::Norm(CenterInMap(cell.x, cell.y) - obstacle.center_in_map) +
            0.5 * options_.resolution_m);
  }
  std::ranges::sort(ages_ms);
  obstacle.age_s = 0.001 * static_cast<double>(ages_ms[ages_ms.size() / 10]);
  return obstacle;
}

}  // namespace treeline::control
