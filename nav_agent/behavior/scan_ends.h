// Where a scan's beams end, seen from above.
#ifndef NAV_AGENT_BEHAVIOR_SCAN_ENDS_H_
#define NAV_AGENT_BEHAVIOR_SCAN_ENDS_H_

#include <cmath>
#include <vector>

#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::behavior {

// On level ground. Of every every-th beam; those without a range are left out,
// or end at the laser's largest range.
inline std::vector<geometry::Vec2> ScanEndsInMap(
    const core::LaserScan& scan, const core::RangeSensorInfo& laser,
    const geometry::Rigid3& base_from_laser,
    const geometry::Rigid2& map_from_base, int every, bool with_no_return) {
  std::vector<geometry::Vec2> ends;
  for (int i = 0; i < static_cast<int>(scan.ranges_m.size()); i += every) {
    double range_m = scan.ranges_m[static_cast<size_t>(i)];
    if (range_m == core::kNoReturn && with_no_return)
      range_m = laser.range_max_m;
    if (!std::isfinite(range_m)) continue;
    const double angle_rad = laser.AngleOf_rad(i);
    const geometry::Vec3 end =
        base_from_laser * geometry::Vec3{range_m * std::cos(angle_rad),
                                         range_m * std::sin(angle_rad), 0};
    ends.push_back(map_from_base * geometry::Vec2{end.x, end.y});
  }
  return ends;
}

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_SCAN_ENDS_H_
