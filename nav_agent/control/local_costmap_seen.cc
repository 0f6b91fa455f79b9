// What a LocalCostmap makes of scans and depth pictures.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "absl/strings/str_cat.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/core/distance_field.h"

namespace treeline::control {
namespace {

// Points this near to the robot are kept for the collision stop (m).
constexpr double kPointReach_m = 2.0;
// What was seen free this long before it was hit was free (ms).
constexpr int64_t kWasFree_ms = 3000;
// A sensor showed it a moment ago, the camera five times a second (ms).
constexpr int64_t kSeenLately_ms = 300;
// A look that passes a cell at more than this above its ground does not see
// what stands there (m).
constexpr double kLookHeight_m = 0.6;
// What is so near to a leg that walks is of the same body or cart (m).
constexpr double kMoverSize_m = 0.5;
constexpr double kUnknownGround = std::numeric_limits<double>::quiet_NaN();

}  // namespace

bool LocalCostmap::IsHeightOfObstacle(core::CellIndex cell, double z_m,
                                      double range_m, bool* near_map) const {
  *near_map = false;
  const double tolerance_m =
      options_.ground_m + options_.ground_per_range * range_m;
  if (!IsInside(cell.x, cell.y)) return false;
  const size_t i = IndexOf(cell.x, cell.y);
  *near_map = map_distance_m_[i] <= options_.map_band_m;
  double ground_m = kUnknownGround;
  if (ground_[i].level >= 0) {
    ground_m = ground_[i].height_m;
  } else {
    // The ground beside it, if there is any.
    for (int y = cell.y - 1; y <= cell.y + 1; ++y) {
      for (int x = cell.x - 1; x <= cell.x + 1; ++x) {
        if (IsInside(x, y) && ground_[IndexOf(x, y)].level >= 0) {
          ground_m = ground_[IndexOf(x, y)].height_m;
        }
      }
    }
  }
  if (std::isnan(ground_m)) ground_m = placed_at_.place.height_m;
  return z_m > ground_m + tolerance_m && z_m < ground_m + robot_.height_m;
}

bool LocalCostmap::IsMoving(core::CellIndex cell, int64_t now_ms) const {
  if (!IsInside(cell.x, cell.y)) return false;
  const size_t at = IndexOf(cell.x, cell.y);
  const auto standing_ms =
      static_cast<int64_t>(1000 * options_.standing_after_s);
  if (map_distance_m_[at] <= 1.6 * options_.map_band_m) return false;
  if (!seen_[at].was_free || now_ms - seen_[at].since_ms > standing_ms) {
    return false;
  }
  // The edges of what stands flicker; what is only remembered does not: who
  // comes back to where somebody stood moves.
  for (int y = cell.y - 1; y <= cell.y + 1; ++y) {
    for (int x = cell.x - 1; x <= cell.x + 1; ++x) {
      if (!IsInside(x, y)) continue;
      const size_t i = IndexOf(x, y);
      if (CountsAt(i) && now_ms - seen_[i].since_ms > standing_ms &&
          now_ms - seen_[i].last_ms < kSeenLately_ms) {
        return false;
      }
    }
  }
  return true;
}

bool LocalCostmap::IsBesideMover(size_t i) const {
  const int cell = static_cast<int>(i);
  const geometry::Vec2 center = CenterInMap(cell % width_, cell / width_);
  return std::ranges::any_of(lasers_, [&](const Laser& laser) {
    return std::ranges::any_of(laser.points, [&](const SeenPoint& point) {
      return point.is_moving &&
             geometry::Norm(point.in_map - center) < kMoverSize_m;
    });
  });
}

void LocalCostmap::ClearAlong(geometry::Vec3 from, geometry::Vec3 to,
                              int64_t now_ms) {
  const double r = options_.resolution_m;
  const geometry::Vec2 way = {to.x - from.x, to.y - from.y};
  const double length_m = geometry::Norm(way);
  const int steps = static_cast<int>(length_m / (0.7 * r));
  if (steps < 1) return;
  const double inverse = 1 / r;
  double x = (from.x - origin_in_map_.x) * inverse;
  double y = (from.y - origin_in_map_.y) * inverse;
  const double step_x = way.x / steps * inverse;
  const double step_y = way.y / steps * inverse;
  const double step_z = (to.z - from.z) / steps;
  double z = from.z;
  size_t last = seen_.size();
  for (int step = 0; step < steps; ++step) {
    if (x >= 0 && y >= 0 && x < width_ && y < height_) {
      const size_t i = IndexOf(static_cast<int>(x), static_cast<int>(y));
      if (i != last) {
        last = i;
        if (passed_in_[i] != look_ && hit_in_[i] + held_looks_ < look_ &&
            ground_[i].level >= 0 && z < ground_[i].height_m + kLookHeight_m) {
          passed_in_[i] = look_;
          Seen& seen = seen_[i];
          seen.laser_hits = static_cast<uint8_t>(
              std::max(0, seen.laser_hits - options_.miss_weight));
          if (seen.laser_hits == 0) seen.last_free_ms = now_ms;
          // It says nothing of what is lower than its plane.
          if (seen.depth_hits == 0) seen.last_ms = now_ms;
        }
      }
    } else if (step > 0 && last != seen_.size()) {
      return;  // it has left the window
    }
    x += step_x;
    y += step_y;
    z += step_z;
  }
}

void LocalCostmap::MarkHits(int64_t now_ms, uint8_t Seen::*hits) {
  for (const size_t i : hit_cells_) {
    Seen& seen = seen_[i];
    // Where the camera saw something, perhaps long ago, the laser may see
    // another thing come.
    if (seen.laser_hits == 0 &&
        (seen.depth_hits == 0 || hits == &Seen::laser_hits)) {
      seen.since_ms = now_ms;
      seen.was_free =
          seen.last_free_ms > 0 && now_ms - seen.last_free_ms < kWasFree_ms;
    }
    seen.is_of_mover = false;
    seen.*hits =
        static_cast<uint8_t>(std::min(options_.most_hits, seen.*hits + 1));
    seen.last_ms = now_ms;
  }
}

absl::Status LocalCostmap::AddScan(const ControlPose& pose,
                                   const core::LaserScan& scan,
                                   core::LaserMount mount) {
  Laser& laser = lasers_[static_cast<size_t>(mount)];
  if (static_cast<int>(scan.ranges_m.size()) != laser.info.beams) {
    return absl::InvalidArgumentError(
        absl::StrCat("a scan has ", scan.ranges_m.size(), " ranges, the laser ",
                     laser.info.beams, " beams"));
  }
  const geometry::Rigid3 map_from_base = MapFromBase3(pose);
  if (!geometry::IsFinite(map_from_base)) {
    return absl::InvalidArgumentError("the pose of a scan is not finite");
  }
  if (!is_placed_) MoveTo(pose);
  const int64_t now_ms = Milliseconds(scan.stamp) + 1;
  laser.last_scan = scan.stamp;
  const geometry::Rigid3 map_from_laser =
      map_from_base * robot_.BaseFrom(mount);
  const geometry::Mat3 rotation = map_from_laser.rotation.Matrix();
  const geometry::Vec3 origin = map_from_laser.translation;
  const geometry::Vec2 at = pose.pose.map_from_base.translation;
  const double heading_x = std::cos(pose.pose.map_from_base.yaw_rad);
  const double heading_y = std::sin(pose.pose.map_from_base.yaw_rad);
  const double reach_m = options_.length_m + options_.width_m;

  ++look_;
  hit_cells_.clear();
  laser.points.clear();
  std::vector<geometry::Vec3> ends(scan.ranges_m.size());
  const auto is_range = [&](size_t i) {
    return scan.ranges_m[i] >= laser.info.range_min_m &&
           scan.ranges_m[i] <= laser.info.range_max_m;
  };
  for (size_t i = 0; i < ends.size(); ++i) {
    // A beam without return passed what is near, unless it is broken.
    const double range_m = is_range(i) ? scan.ranges_m[i] : 0;
    const double used_m = std::min(range_m, reach_m);
    // The robot moved on since the first beam.
    const double late_s = static_cast<double>(i) * laser.info.beam_interval_s;
    const double turn = pose.yaw_rate_radps * late_s;
    const geometry::Vec3 in_laser = {
        used_m * (laser.beam_cos[i] - turn * laser.beam_sin[i]),
        used_m * (laser.beam_sin[i] + turn * laser.beam_cos[i]), 0};
    const double drive_m = pose.forward_mps * late_s;
    const geometry::Vec3 end = {
        origin.x + rotation(0, 0) * in_laser.x + rotation(0, 1) * in_laser.y +
            heading_x * drive_m,
        origin.y + rotation(1, 0) * in_laser.x + rotation(1, 1) * in_laser.y +
            heading_y * drive_m,
        origin.z + rotation(2, 0) * in_laser.x + rotation(2, 1) * in_laser.y};
    ends[i] = end;
    if (range_m == 0 || range_m > reach_m) continue;
    const core::CellIndex cell = CellOf({end.x, end.y});
    bool near_map = false;
    if (!IsHeightOfObstacle(cell, end.z, range_m, &near_map)) continue;
    // One beam alone is an echo from an edge.
    const bool has_neighbour =
        (i > 0 && std::abs(scan.ranges_m[i - 1] - scan.ranges_m[i]) < 0.15F) ||
        (i + 1 < ends.size() &&
         std::abs(scan.ranges_m[i + 1] - scan.ranges_m[i]) < 0.15F);
    if (!has_neighbour) continue;
    const size_t index = IndexOf(cell.x, cell.y);
    if (!near_map && hit_in_[index] != look_) {
      hit_in_[index] = look_;
      hit_cells_.push_back(index);
    }
    if (std::hypot(end.x - at.x, end.y - at.y) < kPointReach_m) {
      laser.points.push_back(
          {.in_map = {end.x, end.y}, .is_new = IsNew(index)});
    }
  }
  for (const geometry::Vec3& end : ends) ClearAlong(origin, end, now_ms);
  MarkHits(now_ms, &Seen::laser_hits);
  for (SeenPoint& point : laser.points) {
    point.is_moving = IsMoving(CellOf(point.in_map), now_ms);
  }
  return absl::OkStatus();
}

absl::Status LocalCostmap::AddDepth(const ControlPose& pose,
                                    const core::RgbdFrame& frame) {
  if (!frame.frame.depth.has_value() || !frame.frame.calibration.has_value()) {
    return absl::InvalidArgumentError(
        "a frame has no depth, or no calibration");
  }
  const image::DepthImage& depth = *frame.frame.depth;
  const camera::RgbdCalibration& calibration = *frame.frame.calibration;
  const size_t pixels =
      static_cast<size_t>(depth.width) * static_cast<size_t>(depth.height);
  if (depth.width < 1 || depth.height < 1 || depth.values.size() != pixels) {
    return absl::InvalidArgumentError("a depth picture has a wrong size");
  }
  const geometry::Rigid3 map_from_base = MapFromBase3(pose);
  if (!geometry::IsFinite(map_from_base)) {
    return absl::InvalidArgumentError("the pose of a frame is not finite");
  }
  if (!is_placed_) MoveTo(pose);
  const int64_t now_ms = Milliseconds(frame.stamp) + 1;
  last_depth_ = frame.stamp;
  const geometry::Rigid3 map_from_depth =
      map_from_base *
      camera::PoseOfSensor(robot_.base_from_camera, calibration.pose_sensor,
                           camera::RgbdSensor::kDepth, calibration);
  const geometry::Vec2 at = pose.pose.map_from_base.translation;
  ++look_;
  hit_cells_.clear();
  depth_points_.clear();
  std::vector<size_t> passed;
  const int stride_px = std::max(1, depth.width / options_.depth_columns);
  for (int y = 0; y < depth.height; y += stride_px) {
    for (int x = 0; x < depth.width; x += stride_px) {
      const uint16_t value = depth.values[static_cast<size_t>(y) *
                                              static_cast<size_t>(depth.width) +
                                          static_cast<size_t>(x)];
      if (!image::IsMeasured(value)) continue;
      const double z_m = value * depth.unit_m * calibration.depth_scale;
      if (z_m > options_.depth_range_m) continue;
      const std::optional<camera::Pixel> ray = calibration.depth.Unproject(
          {static_cast<double>(x), static_cast<double>(y)});
      if (!ray.has_value()) continue;
      const geometry::Vec3 end =
          map_from_depth * geometry::Vec3{ray->x * z_m, ray->y * z_m, z_m};
      const core::CellIndex cell = CellOf({end.x, end.y});
      if (!IsInside(cell.x, cell.y)) continue;
      const size_t index = IndexOf(cell.x, cell.y);
      bool near_map = false;
      if (!IsHeightOfObstacle(cell, end.z, z_m, &near_map)) {
        // What shows its ground is free.
        if (ground_[index].level >= 0 &&
            end.z < ground_[index].height_m + options_.ground_m) {
          passed.push_back(index);
        }
        continue;
      }
      if (!near_map && hit_in_[index] != look_) {
        hit_in_[index] = look_;
        hit_cells_.push_back(index);
      }
      if (std::hypot(end.x - at.x, end.y - at.y) < kPointReach_m) {
        depth_points_.push_back(
            {.in_map = {end.x, end.y}, .is_new = IsNew(index)});
      }
    }
  }
  for (const size_t i : passed) {
    if (hit_in_[i] == look_ || passed_in_[i] == look_) continue;
    passed_in_[i] = look_;
    seen_[i].depth_hits = static_cast<uint8_t>(
        std::max(0, seen_[i].depth_hits - options_.miss_weight));
    seen_[i].last_ms = now_ms;
  }
  MarkHits(now_ms, &Seen::depth_hits);
  for (const size_t i : hit_cells_) seen_[i].is_of_mover = IsBesideMover(i);
  for (SeenPoint& point : depth_points_) {
    point.is_moving = IsMoving(CellOf(point.in_map), now_ms);
  }
  return absl::OkStatus();
}

void LocalCostmap::ClearObstacles() {
  std::ranges::fill(seen_, Seen());
  for (Laser& laser : lasers_) laser.points.clear();
  depth_points_.clear();
  if (is_placed_ && epoch_.has_value()) Update(*epoch_);
}

void LocalCostmap::WidenSeen(std::vector<uint8_t>& is_obstacle) const {
  const double reach_cells = options_.widening_m / options_.resolution_m;
  const int reach = static_cast<int>(reach_cells);
  if (reach < 1) return;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if (At(x, y) != LocalCell::kSeen || !IsNew(IndexOf(x, y))) continue;
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          if (!IsInside(x + dx, y + dy) ||
              dx * dx + dy * dy > reach_cells * reach_cells + 0.5) {
            continue;
          }
          is_obstacle[IndexOf(x + dx, y + dy)] = 1;
        }
      }
    }
  }
}

void LocalCostmap::Update(base::MonotonicTime now) {
  const int64_t now_ms = Milliseconds(now);
  const auto standing_ms =
      static_cast<int64_t>(1000 * options_.standing_after_s);
  std::vector<uint8_t> is_obstacle(cells_.size());
  for (size_t i = 0; i < cells_.size(); ++i) {
    Seen& seen = seen_[i];
    if (seen.laser_hits > 0 || seen.depth_hits > 0) {
      const bool stood =
          seen.last_ms - seen.since_ms > standing_ms && !seen.is_of_mover;
      const double memory_s =
          stood ? options_.standing_memory_s : options_.moving_memory_s;
      if (static_cast<double>(now_ms - seen.last_ms) > 1000 * memory_s) {
        seen = Seen();
      }
    }
    cells_[i] = ground_[i].level < 0 ? LocalCell::kMapObstacle
                : CountsAt(i)        ? LocalCell::kSeen
                                     : LocalCell::kFree;
    is_obstacle[i] = cells_[i] == LocalCell::kFree ? 0 : 1;
  }
  WidenSeen(is_obstacle);
  const std::vector<int32_t> squared =
      core::SquaredDistances(width_, height_, is_obstacle);
  for (size_t i = 0; i < squared.size(); ++i) {
    distance_m_[i] =
        squared[i] == core::kNoObstacle
            ? static_cast<float>(options_.length_m + options_.width_m)
            : static_cast<float>(options_.resolution_m *
                                 std::sqrt(static_cast<double>(squared[i])));
  }
}

}  // namespace treeline::control
