// Floor plans of straight walls, and a laser in them: exact, plus noise.
#ifndef NAV_AGENT_MAPPING_TESTING_PLAN_H_
#define NAV_AGENT_MAPPING_TESTING_PLAN_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "common/base/random.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::mapping {

struct TestWall {
  geometry::Vec2 begin;
  geometry::Vec2 end;
};

inline void AddBox(geometry::Vec2 low, geometry::Vec2 high,
                   std::vector<TestWall>* walls) {
  walls->push_back({{low.x, low.y}, {high.x, low.y}});
  walls->push_back({{high.x, low.y}, {high.x, high.y}});
  walls->push_back({{high.x, high.y}, {low.x, high.y}});
  walls->push_back({{low.x, high.y}, {low.x, low.y}});
}

// 180 degrees ahead, a beam a degree, up to max_m.
inline core::RangeSensorInfo TestLaser(double max_m) {
  return {.angle_min_rad = -std::numbers::pi / 2,
          .angle_increment_rad = std::numbers::pi / 180,
          .beams = 181,
          .range_min_m = 0.02,
          .range_max_m = max_m};
}

// What the laser sees, with Gaussian noise of sigma_m; draws are of stream
// `stream`.
inline std::vector<float> CastScan(const std::vector<TestWall>& walls,
                                   const geometry::Rigid2& map_from_laser,
                                   const core::RangeSensorInfo& laser,
                                   double sigma_m, uint64_t stream) {
  base::Random random(7, stream);
  std::vector<float> ranges_m;
  const geometry::Vec2 o = map_from_laser.translation;
  for (int beam = 0; beam < laser.beams; ++beam) {
    const double angle_rad = map_from_laser.yaw_rad + laser.AngleOf_rad(beam);
    const geometry::Vec2 d = {std::cos(angle_rad), std::sin(angle_rad)};
    double nearest_m = laser.range_max_m;
    for (const TestWall& wall : walls) {
      const geometry::Vec2 along = wall.end - wall.begin;
      const double det = geometry::Cross(d, along);
      if (std::abs(det) < 1e-12) continue;
      const double t = geometry::Cross(wall.begin - o, along) / det;
      const double u = geometry::Cross(wall.begin - o, d) / det;
      if (t > 0 && u >= 0 && u <= 1) nearest_m = std::min(nearest_m, t);
    }
    const double noise_m = sigma_m * random.NextGaussian();
    ranges_m.push_back(nearest_m < laser.range_max_m
                           ? static_cast<float>(nearest_m + noise_m)
                           : core::kNoReturn);
  }
  return ranges_m;
}

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_TESTING_PLAN_H_
