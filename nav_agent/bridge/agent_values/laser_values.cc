#include "nav_agent/bridge/agent_values/laser_values.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "common/ros2/conversions/geometry_values.h"

namespace treeline::agent_values {
namespace {

constexpr int kOccupiedFrom = 65;
constexpr int kFreeUntil = 25;
constexpr uint32_t kMaxCellsASide = 20'000;
// Of maps of ground.
constexpr float kFinestCell_m = 0.005F;
constexpr float kCoarsestCell_m = 100;
// Lasers that turn once have a few thousand.
constexpr int kMaxBeams = 100'000;
// Two turns, which no laser needs.
constexpr double kMaxAngle_rad = 4 * std::numbers::pi;

}  // namespace

absl::StatusOr<core::RangeSensorInfo> SensorInfoOf(
    const messages::LaserScan& scan) {
  const core::RangeSensorInfo info = {
      .angle_min_rad = static_cast<double>(scan.angle_min),
      .angle_increment_rad = static_cast<double>(scan.angle_increment),
      .beams = static_cast<int>(scan.ranges.size()),
      .range_min_m = static_cast<double>(scan.range_min),
      .range_max_m = static_cast<double>(scan.range_max),
      .beam_interval_s = static_cast<double>(scan.time_increment),
      .scan_interval_s = static_cast<double>(scan.scan_time)};
  const bool is_good = info.beams > 0 && info.beams <= kMaxBeams &&
                       std::isfinite(info.angle_min_rad) &&
                       std::isfinite(info.angle_increment_rad) &&
                       info.angle_increment_rad != 0 && info.range_min_m >= 0 &&
                       std::isfinite(info.range_max_m) &&
                       info.range_max_m > info.range_min_m &&
                       info.beam_interval_s >= 0 && info.beam_interval_s < 1;
  // Whoever goes by angle_max would see the mirror image.
  const double span_rad =
      static_cast<double>(scan.angle_max) - info.angle_min_rad;
  if (is_good && std::abs(span_rad) > std::abs(info.angle_increment_rad) &&
      (span_rad > 0) != (info.angle_increment_rad > 0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scan from angle_min ", scan.angle_min, " to angle_max ",
        scan.angle_max, " rad by angle_increment ", scan.angle_increment,
        ": which way do its beams run? Its driver must make them agree"));
  }
  if (is_good && std::max(std::abs(info.angle_min_rad),
                          std::abs(info.angle_increment_rad) *
                              (info.beams - 1)) > kMaxAngle_rad) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scan of ", info.beams, " beams from angle_min ", scan.angle_min,
        " by angle_increment ", scan.angle_increment,
        " rad: more than two turns; are these degrees? Its driver must give "
        "radians"));
  }
  if (is_good) return info;
  return absl::InvalidArgumentError(
      absl::StrCat("scan of ", info.beams, " beams from ", scan.angle_min,
                   " by ", scan.angle_increment, " rad, ", scan.range_min,
                   " to ", scan.range_max, " m: that is no laser"));
}

core::LaserScan ScanOf(const messages::LaserScan& scan) {
  core::LaserScan made;
  made.stamp = conversions::TimeOf(scan.header.stamp);
  made.ranges_m = scan.ranges;
  for (float& range_m : made.ranges_m) {
    if (std::isnan(range_m)) continue;
    if (range_m > scan.range_max) range_m = core::kNoReturn;
    // 0 is what many drivers write for "nothing came back".
    if (range_m < scan.range_min) {
      range_m = range_m == 0 ? core::kInvalidRange : core::kTooNear;
    }
  }
  if (scan.intensities.size() != scan.ranges.size()) return made;
  made.intensities.reserve(scan.intensities.size());
  for (const float value : scan.intensities) {
    made.intensities.push_back(static_cast<uint16_t>(
        std::clamp(value > 0 ? value : 0, 0.0F, 65535.0F)));
  }
  return made;
}

messages::LaserScan MessageOf(const core::LaserScan& scan,
                              const core::RangeSensorInfo& info,
                              const std::string& frame_id) {
  messages::LaserScan message;
  message.header = {.stamp = conversions::StampOf(scan.stamp),
                    .frame_id = frame_id};
  message.angle_min = static_cast<float>(info.angle_min_rad);
  message.angle_max =
      static_cast<float>(info.AngleOf_rad(std::max(info.beams - 1, 0)));
  message.angle_increment = static_cast<float>(info.angle_increment_rad);
  message.time_increment = static_cast<float>(info.beam_interval_s);
  message.scan_time = static_cast<float>(info.scan_interval_s);
  message.range_min = static_cast<float>(info.range_min_m);
  message.range_max = static_cast<float>(info.range_max_m);
  message.ranges = scan.ranges_m;
  for (const uint16_t value : scan.intensities) {
    message.intensities.push_back(static_cast<float>(value));
  }
  return message;
}

absl::StatusOr<core::OccupancyGrid> GridOf(
    const messages::OccupancyGrid& grid) {
  const messages::MapMetaData& info = grid.info;
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 origin,
                      conversions::RigidOf(info.origin));
  if (info.width == 0 || info.height == 0 || info.width > kMaxCellsASide ||
      info.height > kMaxCellsASide ||
      grid.data.size() != size_t{info.width} * info.height ||
      !(info.resolution >= kFinestCell_m) ||
      !(info.resolution <= kCoarsestCell_m)) {
    return absl::InvalidArgumentError(
        absl::StrCat("map of ", info.width, " x ", info.height, " cells of ",
                     info.resolution, " m with ", grid.data.size(), " values"));
  }
  core::OccupancyGrid made = core::OccupancyGrid::Filled(
      static_cast<int>(info.width), static_cast<int>(info.height),
      static_cast<double>(info.resolution), geometry::PlanarPose(origin),
      core::Occupancy::kUnknown);
  std::ranges::transform(grid.data, made.cells.begin(), [](int8_t value) {
    if (value >= kOccupiedFrom) return core::Occupancy::kOccupied;
    if (value >= 0 && value <= kFreeUntil) return core::Occupancy::kFree;
    return core::Occupancy::kUnknown;
  });
  return made;
}

messages::OccupancyGrid MessageOf(const core::OccupancyGrid& grid,
                                  const messages::Header& header) {
  messages::OccupancyGrid message;
  message.header = header;
  message.info.map_load_time = header.stamp;
  message.info.resolution = static_cast<float>(grid.resolution_m);
  message.info.width = static_cast<uint32_t>(grid.width);
  message.info.height = static_cast<uint32_t>(grid.height);
  const geometry::Rigid2& origin = grid.map_from_grid;
  message.info.origin = conversions::PoseOf(
      {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, origin.yaw_rad}),
       .translation = {origin.translation.x, origin.translation.y, 0}});
  message.data.reserve(grid.cells.size());
  for (const core::Occupancy cell : grid.cells) {
    message.data.push_back(
        cell == core::Occupancy::kOccupied
            ? int8_t{100}
            : (cell == core::Occupancy::kFree ? int8_t{0} : int8_t{-1}));
  }
  return message;
}

}  // namespace treeline::agent_values
