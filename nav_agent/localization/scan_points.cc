#include "nav_agent/localization/scan_points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {

namespace {

// What is near fills many beams, and tells no more than what is far and as
// wide: neighbouring ends that count are two cells of the map apart.
constexpr double kEndsApart_m = 2 * kVoxel_m;

geometry::Vec2 EndInLaser(const core::LaserScan& scan,
                          const core::RangeSensorInfo& info, int beam) {
  const double range_m = scan.ranges_m[static_cast<size_t>(beam)];
  const double angle_rad = info.AngleOf_rad(beam);
  return {range_m * std::cos(angle_rad), range_m * std::sin(angle_rad)};
}

// Which beams: of those that have an end, those that end apart; of these at
// most max_points. Choosing among them keeps the number up where half of the
// scan looks into the open.
absl::StatusOr<std::vector<int>> ChosenBeams(const core::LaserScan& scan,
                                             const core::RangeSensorInfo& info,
                                             int max_points) {
  const int beams = static_cast<int>(scan.ranges_m.size());
  if (beams != info.beams) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a scan of ", beams, " beams; the sensor has ", info.beams));
  }
  std::vector<int> ended;
  ended.reserve(scan.ranges_m.size());
  geometry::Vec2 last;
  for (int i = 0; i < beams; ++i) {
    const double range_m = scan.ranges_m[static_cast<size_t>(i)];
    if (!std::isfinite(range_m) || range_m < info.range_min_m ||
        range_m >= info.range_max_m) {
      continue;
    }
    const geometry::Vec2 end = EndInLaser(scan, info, i);
    if (!ended.empty() && geometry::Norm(end - last) < kEndsApart_m) continue;
    last = end;
    ended.push_back(i);
  }
  const int64_t count = static_cast<int64_t>(ended.size());
  const int64_t chosen = std::min<int64_t>(count, max_points);
  std::vector<int> result;
  result.reserve(static_cast<size_t>(chosen));
  for (int64_t k = 0; k < chosen; ++k) {
    // The middle of the k-th of `chosen` equal parts.
    result.push_back(
        ended[static_cast<size_t>((2 * k + 1) * count / (2 * chosen))]);
  }
  return result;
}

}  // namespace

void ScanPoints::Add(const ScanPoints& from, size_t i) {
  if (from.has_heights()) z_m.push_back(from.z_m[i]);
  x_m.push_back(from.x_m[i]);
  y_m.push_back(from.y_m[i]);
}

absl::StatusOr<ScanPoints> PointsOf(const core::LaserScan& scan,
                                    const core::RangeSensorInfo& info,
                                    const geometry::Rigid2& base_from_laser,
                                    int max_points) {
  TL_ASSIGN_OR_RETURN(const std::vector<int> beams,
                      ChosenBeams(scan, info, max_points));
  ScanPoints points;
  points.x_m.reserve(beams.size());
  points.y_m.reserve(beams.size());
  for (const int beam : beams) {
    const geometry::Vec2 point = base_from_laser * EndInLaser(scan, info, beam);
    points.x_m.push_back(static_cast<float>(point.x));
    points.y_m.push_back(static_cast<float>(point.y));
  }
  return points;
}

absl::StatusOr<ScanPoints> PointsInSpace(
    const core::LaserScan& scan, const core::RangeSensorInfo& info,
    const geometry::Rigid3& base_from_laser,
    const geometry::Rotation3& level_from_base, int max_points) {
  TL_ASSIGN_OR_RETURN(const std::vector<int> beams,
                      ChosenBeams(scan, info, max_points));
  const geometry::Rigid3 level_from_laser =
      geometry::Rigid3{.rotation = level_from_base, .translation = {}} *
      base_from_laser;
  ScanPoints points;
  for (const int beam : beams) {
    const geometry::Vec2 end = EndInLaser(scan, info, beam);
    const geometry::Vec3 point =
        level_from_laser * geometry::Vec3{end.x, end.y, 0};
    points.x_m.push_back(static_cast<float>(point.x));
    points.y_m.push_back(static_cast<float>(point.y));
    points.z_m.push_back(static_cast<float>(point.z));
  }
  return points;
}

}  // namespace treeline::localization
