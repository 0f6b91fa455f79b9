#include "nav_agent/control/tracked_scan.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeline::control {

std::optional<BeamTowards> BeamTo(const TrackedScan& look,
                                  geometry::Vec2 in_map) {
  const core::RangeSensorInfo& laser = look.laser;
  const geometry::Vec3 in_laser =
      look.map_from_laser.Inverse() *
      geometry::Vec3{in_map.x, in_map.y, look.map_from_laser.translation.z};
  const double beam =
      (std::atan2(in_laser.y, in_laser.x) - laser.angle_min_rad) /
      laser.angle_increment_rad;
  if (!(beam >= 0 && beam <= laser.beams - 1)) return std::nullopt;
  const float range_m =
      look.scan.ranges_m[static_cast<size_t>(std::lround(beam))];
  if (!(range_m >= laser.range_min_m)) return std::nullopt;
  const double away_m = std::hypot(in_laser.x, in_laser.y);
  return BeamTowards{.range_m = range_m,
                     .away_m = away_m,
                     .to_edge_m = laser.angle_increment_rad * away_m *
                                  std::min(beam, laser.beams - 1 - beam)};
}

}  // namespace treeline::control
