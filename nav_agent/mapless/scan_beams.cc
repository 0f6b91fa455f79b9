#include "nav_agent/mapless/scan_beams.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "common/geometry/planar_pose.h"

namespace treeline::mapless {

std::vector<GridBeam> BeamsOf(const core::LaserScan& scan,
                              const core::RangeSensorInfo& laser,
                              const geometry::Rigid3& base_from_laser,
                              const DeadReckoning& reckoning,
                              double max_range_m) {
  const double duration_s = laser.beam_interval_s * laser.beams;
  const base::MonotonicTime last =
      scan.stamp + std::chrono::duration_cast<base::MonotonicTime::duration>(
                       std::chrono::duration<double>(duration_s));
  const std::optional<geometry::Rigid2> from = reckoning.At(scan.stamp);
  const std::optional<geometry::Rigid2> to = reckoning.At(last);
  if (!from.has_value() || !to.has_value()) return {};
  const geometry::Rigid2 in_base = geometry::PlanarPose(base_from_laser);
  const geometry::Vec2 way = to->translation - from->translation;
  const double turn_rad =
      geometry::NormalizedAngle_rad(to->yaw_rad - from->yaw_rad);
  std::vector<GridBeam> beams;
  beams.reserve(scan.ranges_m.size());
  for (size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const auto range_m = static_cast<double>(scan.ranges_m[i]);
    if (!(range_m >= laser.range_min_m && range_m <= laser.range_max_m) ||
        range_m > max_range_m) {
      continue;
    }
    const double share =
        static_cast<double>(i) / static_cast<double>(scan.ranges_m.size());
    const geometry::Rigid2 map_from_laser =
        geometry::Rigid2{from->translation + share * way,
                         from->yaw_rad + share * turn_rad} *
        in_base;
    const double angle_rad = laser.AngleOf_rad(static_cast<int>(i));
    beams.push_back(
        {.from = map_from_laser.translation,
         .to = map_from_laser * geometry::Vec2{range_m * std::cos(angle_rad),
                                               range_m * std::sin(angle_rad)}});
  }
  return beams;
}

}  // namespace treeline::mapless
