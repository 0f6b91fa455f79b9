#include "nav_agent/control/laser_observer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "absl/strings/str_cat.h"
#include "nav_agent/control/obstacle_parameters.h"

namespace treeline::control {
namespace {

// One beam alone is an echo from an edge.
bool HasNeighbour(const core::LaserScan& scan, size_t beam) {
  constexpr auto kGap_m = static_cast<float>(kNeighbourGap_m.value);
  const std::vector<float>& ranges_m = scan.ranges_m;
  return (beam > 0 && std::abs(ranges_m[beam - 1] - ranges_m[beam]) < kGap_m) ||
         (beam + 1 < ranges_m.size() &&
          std::abs(ranges_m[beam + 1] - ranges_m[beam]) < kGap_m);
}

}  // namespace

LaserObserver::LaserObserver(const core::RangeSensorInfo& info,
                             const geometry::Rigid3& base_from_laser,
                             double robot_height_m, double reach_m)
    : info_(info),
      base_from_laser_(base_from_laser),
      robot_height_m_(robot_height_m),
      reach_m_(reach_m) {
  for (int beam = 0; beam < info_.beams; ++beam) {
    beam_cos_.push_back(std::cos(info_.AngleOf_rad(beam)));
    beam_sin_.push_back(std::sin(info_.AngleOf_rad(beam)));
  }
}

absl::Status LaserObserver::Check(const core::LaserScan& scan) const {
  if (static_cast<int>(scan.ranges_m.size()) == info_.beams) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("a scan has ", scan.ranges_m.size(), " ranges, the laser ",
                   info_.beams, " beams"));
}

// 0: none. A beam without return passed what is near, unless it is broken.
double LaserObserver::RangeOf_m(const core::LaserScan& scan,
                                size_t beam) const {
  const float range_m = scan.ranges_m[beam];
  const bool is_range =
      range_m >= info_.range_min_m && range_m <= info_.range_max_m;
  return is_range ? range_m : 0;
}

std::vector<geometry::Vec3> LaserObserver::EndsOf(
    const ControlPose& pose, const core::LaserScan& scan,
    const geometry::Rigid3& map_from_laser) const {
  const geometry::Mat3 rotation = map_from_laser.rotation.Matrix();
  const geometry::Vec3 origin = map_from_laser.translation;
  const double heading_x = std::cos(pose.pose.map_from_base.yaw_rad);
  const double heading_y = std::sin(pose.pose.map_from_base.yaw_rad);
  std::vector<geometry::Vec3> ends(scan.ranges_m.size());
  for (size_t i = 0; i < ends.size(); ++i) {
    const double used_m = std::min(RangeOf_m(scan, i), reach_m_);
    const double late_s = static_cast<double>(i) * info_.beam_interval_s;
    const double turn = pose.yaw_rate_radps * late_s;
    const geometry::Vec3 in_laser = {
        used_m * (beam_cos_[i] - turn * beam_sin_[i]),
        used_m * (beam_sin_[i] + turn * beam_cos_[i]), 0};
    const double drive_m = pose.forward_mps * late_s;
    ends[i] = {
        origin.x + rotation(0, 0) * in_laser.x + rotation(0, 1) * in_laser.y +
            heading_x * drive_m,
        origin.y + rotation(1, 0) * in_laser.x + rotation(1, 1) * in_laser.y +
            heading_y * drive_m,
        origin.z + rotation(2, 0) * in_laser.x + rotation(2, 1) * in_laser.y};
  }
  return ends;
}

void LaserObserver::Add(const ControlPose& pose, const core::LaserScan& scan,
                        const CostmapWindow& window, const GroundLayer& ground,
                        int64_t now_ms, ObstacleLayer& obstacles) {
  last_scan_ = scan.stamp;
  const geometry::Rigid3 map_from_laser = MapFromBase3(pose) * base_from_laser_;
  const geometry::Vec2 at = pose.pose.map_from_base.translation;
  const std::vector<geometry::Vec3> ends = EndsOf(pose, scan, map_from_laser);
  points_.clear();
  obstacles.BeginLook();
  for (size_t i = 0; i < ends.size(); ++i) {
    const double range_m = RangeOf_m(scan, i);
    if (range_m == 0 || range_m > reach_m_) continue;
    const geometry::Vec3& end = ends[i];
    const core::CellIndex cell = window.CellOf({end.x, end.y});
    if (!ground.IsHeightOfObstacle(window, cell, end.z, range_m,
                                   robot_height_m_) ||
        !HasNeighbour(scan, i)) {
      continue;
    }
    const size_t index = window.IndexOf(cell.x, cell.y);
    if (!ground.IsNearMap(index)) obstacles.Hit(index);
    if (std::hypot(end.x - at.x, end.y - at.y) < kPointReach_m) {
      points_.push_back(
          {.in_map = {end.x, end.y}, .is_new = obstacles.IsNew(index, ground)});
    }
  }
  for (const geometry::Vec3& end : ends) {
    obstacles.ClearAlong(window, ground, map_from_laser.translation, end,
                         now_ms);
  }
  map_from_laser_ = map_from_laser;
  ends_ = ends;
  obstacles.MarkLaserHits(now_ms);
  for (ObservedPoint& point : points_) {
    point.is_moving =
        obstacles.IsMoving(window, ground, window.CellOf(point.in_map), now_ms);
  }
}

LaserSight LaserObserver::Look(const ThingColumn& column) const {
  if (ends_.empty()) return {};
  const geometry::Vec3& from = map_from_laser_.translation;
  const geometry::Vec3 in_laser =
      map_from_laser_.Inverse() *
      geometry::Vec3{column.center_in_map.x, column.center_in_map.y, from.z};
  const double away_m = std::hypot(in_laser.x, in_laser.y);
  if (away_m < 2 * column.half_width_m) return {};
  const double half_rad = std::atan2(column.half_width_m, away_m);
  const double middle =
      (std::atan2(in_laser.y, in_laser.x) - info_.angle_min_rad) /
      info_.angle_increment_rad;
  const double half = std::abs(half_rad / info_.angle_increment_rad);
  const int begin = static_cast<int>(std::floor(middle - half));
  const int end = static_cast<int>(std::ceil(middle + half));
  if (begin < 0 || end >= info_.beams) return {};
  LaserSight result = {.sight = ColumnSight::kThrough,
                       .range_m = std::numeric_limits<double>::infinity()};
  for (int beam = begin; beam <= end; ++beam) {
    const geometry::Vec3 way = ends_[static_cast<size_t>(beam)] - from;
    const double range_m = std::hypot(way.x, way.y);
    result.range_m = std::min(result.range_m, range_m);
    const double part = range_m > away_m ? away_m / range_m : 1;
    const double above_m = from.z + part * way.z - column.ground_m;
    const bool is_of_things =
        above_m > kGroundTolerance_m && above_m < kLookHeight_m;
    if (range_m < away_m - kThingDepth_m || !is_of_things) {
      result.sight = ColumnSight::kUnknown;
    } else if (range_m <= away_m + kThingDepth_m) {
      result.sight = ColumnSight::kMet;
      break;
    }
  }
  return result;
}

bool LaserObserver::ShowsMoverNear(geometry::Vec2 in_map) const {
  return std::ranges::any_of(points_, [&](const ObservedPoint& point) {
    return point.is_moving &&
           geometry::Norm(point.in_map - in_map) < kLegReach_m;
  });
}

}  // namespace treeline::control
