#include "nav_agent/localization/scan_points.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace treeline {

absl::StatusOr<ScanPoints> PointsOf(const LaserScan& scan,
                                    const RangeSensorInfo& info,
                                    const Rigid2& base_from_laser,
                                    int max_points) {
  const int beams = static_cast<int>(scan.ranges_m.size());
  if (beams != info.beams) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a scan of ", beams, " beams; the sensor has ", info.beams));
  }
  // Those that have an end, first: choosing among them keeps the number up
  // where half of the scan looks into the open.
  std::vector<int> ended;
  ended.reserve(scan.ranges_m.size());
  for (int i = 0; i < beams; ++i) {
    const double range_m = scan.ranges_m[static_cast<size_t>(i)];
    if (std::isfinite(range_m) && range_m >= info.range_min_m &&
        range_m < info.range_max_m) {
      ended.push_back(i);
    }
  }
  const int64_t count = static_cast<int64_t>(ended.size());
  const int64_t chosen = std::min<int64_t>(count, max_points);
  ScanPoints points;
  points.x_m.reserve(static_cast<size_t>(chosen));
  points.y_m.reserve(static_cast<size_t>(chosen));
  for (int64_t k = 0; k < chosen; ++k) {
    // The middle of the k-th of `chosen` equal parts.
    const int beam =
        ended[static_cast<size_t>((2 * k + 1) * count / (2 * chosen))];
    const double range_m = scan.ranges_m[static_cast<size_t>(beam)];
    const double angle_rad = info.AngleOf_rad(beam);
    const Vec2 point = base_from_laser * Vec2{range_m * std::cos(angle_rad),
                                              range_m * std::sin(angle_rad)};
    points.x_m.push_back(static_cast<float>(point.x));
    points.y_m.push_back(static_cast<float>(point.y));
  }
  return points;
}

}  // namespace treeline
