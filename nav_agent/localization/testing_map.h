// A small map for tests, and what a laser sees in it.
#ifndef NAV_AGENT_LOCALIZATION_TESTING_MAP_H_
#define NAV_AGENT_LOCALIZATION_TESTING_MAP_H_

#include <cmath>

#include "common/base/random.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::localization {

// 12 x 8 m at 0.05 m, with walls around it, a wall with a door across it, and
// a few pillars: no two places look the same.
inline core::OccupancyGrid TestingMap() {
  core::OccupancyGrid map = core::OccupancyGrid::Filled(
      240, 160, 0.05, {.translation = {-2, -1}, .yaw_rad = 0.3},
      core::Occupancy::kFree);
  const auto fill = [&map](int x0, int y0, int x1, int y1) {
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) map.Set({x, y}, core::Occupancy::kOccupied);
    }
  };
  fill(0, 0, 240, 2);
  fill(0, 158, 240, 160);
  fill(0, 0, 2, 160);
  fill(238, 0, 240, 160);
  fill(130, 0, 133, 60);
  fill(130, 85, 133, 160);
  fill(40, 100, 60, 112);
  fill(180, 30, 190, 40);
  fill(200, 110, 238, 114);
  return map;
}

inline core::RangeSensorInfo TestingLaser() {
  return {.angle_min_rad = -1.5,
          .angle_increment_rad = 3.0 / 180,
          .beams = 181,
          .range_min_m = 0.05,
          .range_max_m = 20,
          .beam_interval_s = 0,
          .scan_interval_s = 0.1};
}

// The scan of a laser at map_from_laser, by small steps along each beam, with
// Gaussian noise.
inline core::LaserScan ScanOf(const core::OccupancyGrid& map,
                              const core::RangeSensorInfo& info,
                              const geometry::Rigid2& map_from_laser,
                              double noise_m, base::Random& random) {
  core::LaserScan scan;
  for (int beam = 0; beam < info.beams; ++beam) {
    const double angle_rad = info.AngleOf_rad(beam);
    double range_m = 0;
    while (range_m < info.range_max_m) {
      const geometry::Vec2 point =
          map_from_laser * geometry::Vec2{range_m * std::cos(angle_rad),
                                          range_m * std::sin(angle_rad)};
      if (map.AtOrUnknown(map.CellOf(point)) == core::Occupancy::kOccupied)
        break;
      range_m += 0.02;
    }
    scan.ranges_m.push_back(
        range_m < info.range_max_m
            ? static_cast<float>(range_m + noise_m * random.NextGaussian())
            : core::kNoReturn);
  }
  return scan;
}

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_TESTING_MAP_H_
