#include "nav_agent/localization/lost_scan_check.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "nav_agent/core/distance_field.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {
namespace {

// A beam that has a return, in the frame of the base when that is level.
struct Measured {
  int beam = 0;
  geometry::Vec2 end;
  // Along the ground.
  double range_m = 0;
  geometry::Vec2 direction;
  // Of its end above the ground that the wheels stand on, and how much it
  // rises with each metre along the ground.
  double height_m = 0;
  double rise = 0;
};

struct Leveled {
  geometry::Vec3 origin;
  std::vector<Measured> beams;
};

Leveled LevelBeams(const ScanPose& pose, const core::RangeSensorInfo& info,
                   const geometry::Rigid3& base_from_laser,
                   const core::LaserScan& scan, int max_beams) {
  const geometry::Rotation3 level_from_base =
      geometry::Rotation3::FromAxisAngle({0, pose.pitch_rad, 0}) *
      geometry::Rotation3::FromAxisAngle({pose.roll_rad, 0, 0});
  const geometry::Rotation3 level_from_laser =
      level_from_base * base_from_laser.rotation;
  Leveled leveled;
  leveled.origin = level_from_base * base_from_laser.translation;
  const int count = std::min(max_beams, info.beams);
  leveled.beams.reserve(static_cast<size_t>(count));
  for (int k = 0; k < count; ++k) {
    const int beam = static_cast<int>((2 * int64_t{k} + 1) * info.beams /
                                      (2 * int64_t{count}));
    const double range_m = scan.ranges_m[static_cast<size_t>(beam)];
    if (!std::isfinite(range_m) || range_m < info.range_min_m ||
        range_m >= std::min(info.range_max_m, kMaxBeamRange_m.value)) {
      continue;
    }
    const double angle_rad = info.AngleOf_rad(beam);
    const geometry::Vec3 along =
        level_from_laser *
        geometry::Vec3{std::cos(angle_rad), std::sin(angle_rad), 0};
    const double level = std::hypot(along.x, along.y);
    if (level < kMinLevelShare) continue;
    leveled.beams.push_back({.beam = k,
                             .end = {leveled.origin.x + range_m * along.x,
                                     leveled.origin.y + range_m * along.y},
                             .range_m = range_m * level,
                             .direction = {along.x / level, along.y / level},
                             .height_m = leveled.origin.z + range_m * along.z,
                             .rise = along.z / level});
  }
  return leveled;
}

absl::Status CheckBeams(const core::LaserScan& scan,
                        const core::RangeSensorInfo& info) {
  if (static_cast<int>(scan.ranges_m.size()) == info.beams) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("a scan of ", scan.ranges_m.size(),
                   " beams; the sensor has ", info.beams));
}

bool IsAtLaserHeight(const Measured& beam, double laser_height_m,
                     const ScanCheckOptions& options) {
  return beam.height_m >= options.ground_m &&
         std::abs(beam.height_m - laser_height_m) <= options.height_tolerance_m;
}

}  // namespace

absl::Status ScanCheckOptions::Validate() const {
  TL_RETURN_IF_ERROR(
      base::CheckRange("scan check: max_beams", max_beams, 8, 2000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("scan check: tolerance_m", tolerance_m, 0.01, 2));
  TL_RETURN_IF_ERROR(
      base::CheckRange("scan check: tolerance_share", tolerance_share, 0, 0.5));
  TL_RETURN_IF_ERROR(
      base::CheckRange("scan check: nearest_m", nearest_m, 0, 2));
  TL_RETURN_IF_ERROR(
      base::CheckRange("scan check: field_reach_m", field_reach_m, 0.1, 20));
  TL_RETURN_IF_ERROR(base::CheckRange("scan check: ground_m", ground_m, 0, 1));
  return base::CheckRange("scan check: height_tolerance_m", height_tolerance_m,
                          0.01, 5);
}

absl::StatusOr<ScanPoints> PointsAtLaserHeight(
    const core::LaserScan& scan, const core::RangeSensorInfo& info,
    const geometry::Rigid3& base_from_laser, double pitch_rad, double roll_rad,
    int max_points, const ScanCheckOptions& options) {
  TL_RETURN_IF_ERROR(CheckBeams(scan, info));
  const Leveled leveled = LevelBeams({{}, pitch_rad, roll_rad}, info,
                                     base_from_laser, scan, max_points);
  ScanPoints points;
  for (const Measured& beam : leveled.beams) {
    if (!IsAtLaserHeight(beam, leveled.origin.z, options)) continue;
    points.x_m.push_back(static_cast<float>(beam.end.x));
    points.y_m.push_back(static_cast<float>(beam.end.y));
  }
  return points;
}

absl::StatusOr<ScanChecker> ScanChecker::Create(
    const LaserMap& map, const ScanCheckOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  for (const core::OccupancyGrid* grid : {&map.map, &map.opaque}) {
    if (grid->width < 1 || grid->height < 1 || !(grid->resolution_m > 0) ||
        grid->width != map.map.width || grid->height != map.map.height ||
        grid->resolution_m != map.map.resolution_m ||
        grid->map_from_grid != map.map.map_from_grid ||
        grid->cells.size() != static_cast<size_t>(grid->width) *
                                  static_cast<size_t>(grid->height)) {
      return absl::InvalidArgumentError(
          "scan check: a map without cells, or two of different size");
    }
  }
  return ScanChecker(map, options);
}

ScanChecker::ScanChecker(const LaserMap& map, const ScanCheckOptions& options)
    : options_(options),
      opaque_(map.opaque),
      grid_from_map_(map.map.map_from_grid.Inverse()),
      distances_m_(core::DistanceToOccupied(map.map, options.field_reach_m)),
      opaque_distances_m_(
          core::DistanceToOccupied(map.opaque, options.field_reach_m)) {}

double ScanChecker::DistanceAt_m(geometry::Vec2 point_in_map) const {
  const geometry::Vec2 point = grid_from_map_ * point_in_map;
  const core::CellIndex cell = {
      static_cast<int>(std::floor(point.x / opaque_.resolution_m)),
      static_cast<int>(std::floor(point.y / opaque_.resolution_m))};
  return opaque_.Contains(cell) ? distances_m_[opaque_.IndexOf(cell)]
                                : options_.field_reach_m;
}

ScanChecker::Ray ScanChecker::Cast(geometry::Vec2 from_in_map,
                                   geometry::Vec2 direction_in_map,
                                   double max_m) const {
  const geometry::Vec2 from = grid_from_map_ * from_in_map;
  const geometry::Vec2 ahead =
      grid_from_map_ * (from_in_map + direction_in_map) - from;
  const double cell_m = opaque_.resolution_m;
  // As far as the distance field says that nothing is (sphere tracing): it is
  // of cells' centres, which are up to half a diagonal from where we are and
  // from where the obstacle begins.
  double range_m = options_.nearest_m;
  while (range_m < max_m) {
    const geometry::Vec2 at = from + range_m * ahead;
    const core::CellIndex cell = {static_cast<int>(std::floor(at.x / cell_m)),
                                  static_cast<int>(std::floor(at.y / cell_m))};
    if (!opaque_.Contains(cell)) return {range_m, false};
    const core::Occupancy occupancy = opaque_.At(cell);
    if (occupancy == core::Occupancy::kOccupied) return {range_m, true};
    if (occupancy == core::Occupancy::kUnknown) return {range_m, false};
    const double free_m = opaque_distances_m_[opaque_.IndexOf(cell)];
    range_m += std::max(0.5 * cell_m, free_m - 1.5 * cell_m);
  }
  return {max_m, true};
}

absl::StatusOr<std::vector<CheckedBeam>> ScanChecker::Check(
    const ScanPose& pose, const core::RangeSensorInfo& info,
    const geometry::Rigid3& base_from_laser,
    const core::LaserScan& scan) const {
  TL_RETURN_IF_ERROR(CheckBeams(scan, info));
  const geometry::Rigid2& map_from_base = pose.map_from_base;
  if (!std::isfinite(map_from_base.translation.x) ||
      !std::isfinite(map_from_base.translation.y) ||
      !std::isfinite(map_from_base.yaw_rad) || !std::isfinite(pose.pitch_rad) ||
      !std::isfinite(pose.roll_rad)) {
    return absl::InvalidArgumentError("scan check: the pose is not finite");
  }
  const Leveled leveled =
      LevelBeams(pose, info, base_from_laser, scan, options_.max_beams);
  const geometry::Vec2 from =
      map_from_base * geometry::Vec2{leveled.origin.x, leveled.origin.y};
  const auto tolerance_at = [this](double range_m) {
    return options_.tolerance_m + options_.tolerance_share * range_m;
  };
  std::vector<Ray> rays;
  rays.reserve(leveled.beams.size());
  for (size_t i = 0; i < leveled.beams.size(); ++i) {
    const geometry::Vec2 ahead =
        map_from_base * leveled.beams[i].direction - map_from_base.translation;
    // What lies beyond the ends, its own and its neighbours', does not matter.
    double reach_m = leveled.beams[i].range_m;
    if (i > 0) reach_m = std::max(reach_m, leveled.beams[i - 1].range_m);
    if (i + 1 < leveled.beams.size()) {
      reach_m = std::max(reach_m, leveled.beams[i + 1].range_m);
    }
    rays.push_back(Cast(from, ahead, reach_m + 2 * tolerance_at(reach_m)));
  }
  std::vector<CheckedBeam> checked(leveled.beams.size());
  for (size_t i = 0; i < checked.size(); ++i) {
    const Measured& beam = leveled.beams[i];
    // The farthest of what the map has for it and its neighbours.
    Ray ray = rays[i];
    for (const size_t next : {i - 1, i + 1}) {
      if (next >= rays.size() ||
          std::abs(leveled.beams[next].beam - beam.beam) != 1) {
        continue;
      }
      ray.is_known = ray.is_known && rays[next].is_known;
      ray.range_m = std::max(ray.range_m, rays[next].range_m);
    }
    const double tolerance_m = tolerance_at(beam.range_m);
    const double distance_m = DistanceAt_m(map_from_base * beam.end);
    CheckedBeam& result = checked[i];
    result.end_in_base = beam.end;
    result.distance_m = distance_m;
    if (beam.range_m > ray.range_m + tolerance_m) {
      // Over or under what the map has there, or into what it does not know.
      const bool meets = ray.is_known && std::abs(beam.rise * ray.range_m) <
                                             options_.height_tolerance_m;
      result.fit = meets ? BeamFit::kLong : BeamFit::kNotJudged;
    } else if (distance_m <= tolerance_m) {
      result.fit = BeamFit::kExplained;
    } else if (!IsAtLaserHeight(beam, leveled.origin.z, options_)) {
      result.fit = BeamFit::kNotJudged;
    } else {
      result.fit = BeamFit::kShort;
    }
  }
  return checked;
}

}  // namespace treeline::localization
