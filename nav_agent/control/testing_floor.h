// A floor for tests, and what a laser sees on it.
#ifndef NAV_AGENT_CONTROL_TESTING_FLOOR_H_
#define NAV_AGENT_CONTROL_TESTING_FLOOR_H_

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include "nav_agent/control/control_pose.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::control {

// 12 x 12 m of free ground at height 0, cells of 0.05 m.
class TestingFloor {
 public:
  TestingFloor() {
    level_.grid =
        core::OccupancyGrid::Filled(240, 240, 0.05, {}, core::Occupancy::kFree);
    level_.height_m.assign(level_.grid.cells.size(), -0.025F);
    level_.slope_rad.assign(level_.grid.cells.size(), 0.0F);
    level_.clearance_m.assign(level_.grid.cells.size(),
                              std::numeric_limits<float>::infinity());
  }

  TestingFloor& Fill(geometry::Vec2 low, geometry::Vec2 high,
                     core::Occupancy value) {
    return ForEach(low, high, [this, value](core::CellIndex cell) {
      level_.grid.Set(cell, value);
    });
  }
  // Rises along x from 0 at low.x on, in voxels.
  TestingFloor& Ramp(geometry::Vec2 low, geometry::Vec2 high, double slope) {
    return ForEach(low, high, [this, low, slope](core::CellIndex cell) {
      const double rise_m = slope * (level_.grid.CenterInMap(cell).x - low.x);
      const size_t i = level_.grid.IndexOf(cell);
      level_.height_m[i] =
          static_cast<float>(0.05 * std::floor(rise_m / 0.05) - 0.025);
      level_.slope_rad[i] = static_cast<float>(std::atan(slope));
    });
  }
  TestingFloor& Raise(geometry::Vec2 low, geometry::Vec2 high,
                      double height_m) {
    return ForEach(low, high, [this, height_m](core::CellIndex cell) {
      level_.height_m[level_.grid.IndexOf(cell)] =
          static_cast<float>(height_m - 0.025);
    });
  }
  const traversability::TraversableLevel& level() const { return level_; }
  std::shared_ptr<const traversability::NavigationMap> Map() const {
    traversability::TraversableMap map;
    map.levels.push_back(level_);
    return std::make_shared<const traversability::NavigationMap>(
        *traversability::NavigationMap::Make(std::move(map)));
  }

 private:
  TestingFloor& ForEach(geometry::Vec2 low, geometry::Vec2 high,
                        const std::function<void(core::CellIndex)>& change) {
    for (int y = 0; y < level_.grid.height; ++y) {
      for (int x = 0; x < level_.grid.width; ++x) {
        const geometry::Vec2 at = level_.grid.CenterInMap({x, y});
        if (at.x > low.x && at.x < high.x && at.y > low.y && at.y < high.y) {
          change({x, y});
        }
      }
    }
    return *this;
  }

  traversability::TraversableLevel level_;
};

inline core::RangeSensorInfo TestingLaser() {
  return {.angle_min_rad = -0.75 * std::numbers::pi,
          .angle_increment_rad = 1.5 * std::numbers::pi / 540,
          .beams = 541,
          .range_min_m = 0.1,
          .range_max_m = 30,
          .beam_interval_s = 0,
          .scan_interval_s = 0.025};
}

inline base::MonotonicTime TestingTime(double seconds) {
  return base::MonotonicTime(
      std::chrono::duration_cast<base::MonotonicTime::duration>(
          std::chrono::duration<double>(100 + seconds)));
}

inline ControlPose TestingPose(double x_m, double y_m, double yaw_rad = 0,
                               double time_s = 0) {
  ControlPose pose;
  pose.stamp = TestingTime(time_s);
  pose.pose.map_from_base = {.translation = {x_m, y_m}, .yaw_rad = yaw_rad};
  return pose;
}

// On level ground, from 0.22 m before the base, or as far behind it and looking
// back, with walls all around 8 m from the origin of the beams.
inline core::LaserScan TestingScan(
    const ControlPose& pose,
    const std::function<bool(geometry::Vec2)>& is_solid,
    core::LaserMount mount = core::LaserMount::kFront) {
  const core::RangeSensorInfo laser = TestingLaser();
  core::LaserScan scan;
  scan.stamp = pose.stamp;
  const bool looks_back = mount == core::LaserMount::kRear;
  const geometry::Rigid2 map_from_laser =
      pose.pose.map_from_base *
      geometry::Rigid2{.translation = {looks_back ? -0.22 : 0.22, 0},
                       .yaw_rad = looks_back ? std::numbers::pi : 0};
  for (int beam = 0; beam < laser.beams; ++beam) {
    const double angle_rad = laser.AngleOf_rad(beam);
    double range_m = 0.1;
    while (range_m < 8 &&
           !is_solid(map_from_laser *
                     geometry::Vec2{range_m * std::cos(angle_rad),
                                    range_m * std::sin(angle_rad)})) {
      range_m += 0.01;
    }
    scan.ranges_m.push_back(static_cast<float>(range_m));
  }
  return scan;
}

inline std::function<bool(geometry::Vec2)> TestingBox(geometry::Vec2 low,
                                                      geometry::Vec2 high) {
  return [low, high](geometry::Vec2 at) {
    return at.x > low.x && at.x < high.x && at.y > low.y && at.y < high.y;
  };
}
inline bool NothingThere(geometry::Vec2 /*at*/) { return false; }

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_TESTING_FLOOR_H_
