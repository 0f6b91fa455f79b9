#include "simulation/emulators/laser_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"

namespace treeline::emulators {
namespace {

// What a white wall one metre away gives, about, in the sensor's units.
constexpr double kIntensityAtOneMetre = 4000;

// How far it is along one axis from `position` to the wall at +- half.
double AlongAxis(double position, double direction, double half) {
  if (std::abs(direction) < 1e-12) {
    return std::numeric_limits<double>::infinity();
  }
  return ((direction > 0 ? half : -half) - position) / direction;
}

}  // namespace

absl::Status RoomOptions::Validate() const {
  if (!(width_m > 0 && width_m <= 1000 && depth_m > 0 && depth_m <= 1000)) {
    return absl::InvalidArgumentError(
        "a room must be between 0 and 1000 m wide and deep");
  }
  if (!(std::abs(laser_x_m) < width_m / 2 &&
        std::abs(laser_y_m) < depth_m / 2)) {
    return absl::InvalidArgumentError("the laser stands outside its room");
  }
  if (!std::isfinite(laser_yaw_rad) || !(noise_m >= 0 && noise_m <= 10) ||
      !(dropout >= 0 && dropout <= 1)) {
    return absl::InvalidArgumentError(
        "a room's noise must be 0 to 10 m, its drop-out 0 to 1, and the yaw a "
        "number");
  }
  return absl::OkStatus();
}

absl::StatusOr<RoomOptions> ParseRoom(absl::string_view text) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(text, absl::MaxSplits('x', 1));
  RoomOptions room;
  if (!absl::SimpleAtod(parts.first, &room.width_m) ||
      !absl::SimpleAtod(parts.second, &room.depth_m)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "\"", text, "\" is no room: width x depth in metres, such as 8x6"));
  }
  TL_RETURN_IF_ERROR(room.Validate());
  return room;
}

double DistanceToWall_m(const RoomOptions& room, double bearing_rad) {
  const double angle = room.laser_yaw_rad + bearing_rad;
  return std::min(AlongAxis(room.laser_x_m, std::cos(angle), room.width_m / 2),
                  AlongAxis(room.laser_y_m, std::sin(angle), room.depth_m / 2));
}

core::LaserScan RoomLaserSource::ScanAt(base::MonotonicTime start,
                                        const core::RangeSensorInfo& info) {
  core::LaserScan scan = {.stamp = start, .ranges_m = {}, .intensities = {}};
  base::Random random(room_.seed,
                      static_cast<uint64_t>(start.time_since_epoch().count()));
  for (int beam = 0; beam < info.beams; ++beam) {
    const double distance_m = DistanceToWall_m(room_, info.AngleOf_rad(beam));
    const bool lost = random.NextUnit() < room_.dropout;
    const double noise_m = room_.noise_m * random.NextGaussian();
    scan.ranges_m.push_back(lost ? core::kNoReturn
                                 : static_cast<float>(distance_m + noise_m));
    scan.intensities.push_back(static_cast<uint16_t>(
        lost ? 0 : kIntensityAtOneMetre / std::max(1.0, distance_m)));
  }
  return scan;
}

}  // namespace treeline::emulators
