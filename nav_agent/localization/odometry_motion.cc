#include "nav_agent/localization/odometry_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline {
namespace {

// Below this way the direction of driving means nothing: a turn on the spot.
constexpr double kNoDrive_m = 0.01;

// The size of a turn, whichever way the robot faced: driving backwards is no
// half turn.
double TurnSize_rad(double turn_rad) {
  return std::min(std::abs(turn_rad),
                  std::abs(NormalizedAngle_rad(turn_rad + std::numbers::pi)));
}

}  // namespace

absl::Status OdometryNoise::Validate() const {
  const std::pair<const char*, double> shares[] = {
      {"turn_from_turn", turn_from_turn},
      {"turn_from_drive", turn_from_drive},
      {"drive_from_drive", drive_from_drive},
      {"drive_from_turn", drive_from_turn}};
  for (const auto& [name, value] : shares) {
    if (!(value >= 0) || !(value <= 10)) {
      return absl::InvalidArgumentError(absl::StrCat(
          "odometry noise: ", name, " is ", value, "; it must be 0..10"));
    }
  }
  return absl::OkStatus();
}

OdometryMotion::OdometryMotion(const Rigid2& before_from_after,
                               const OdometryNoise& noise) {
  const Vec2 way = before_from_after.translation;
  drive_m_ = Norm(way);
  turn_before_rad_ = drive_m_ < kNoDrive_m ? 0 : std::atan2(way.y, way.x);
  turn_after_rad_ =
      NormalizedAngle_rad(before_from_after.yaw_rad - turn_before_rad_);
  const double before_rad = TurnSize_rad(turn_before_rad_);
  const double after_rad = TurnSize_rad(turn_after_rad_);
  turn_before_sigma_rad_ =
      noise.turn_from_turn * before_rad + noise.turn_from_drive * drive_m_;
  turn_after_sigma_rad_ =
      noise.turn_from_turn * after_rad + noise.turn_from_drive * drive_m_;
  drive_sigma_m_ = noise.drive_from_drive * drive_m_ +
                   noise.drive_from_turn * (before_rad + after_rad);
}

Rigid2 OdometryMotion::Sample(const Rigid2& map_from_before,
                              Random& random) const {
  const double turn_before_rad =
      turn_before_rad_ + turn_before_sigma_rad_ * random.NextGaussian();
  const double drive_m = drive_m_ + drive_sigma_m_ * random.NextGaussian();
  const double turn_after_rad =
      turn_after_rad_ + turn_after_sigma_rad_ * random.NextGaussian();
  const double course_rad = map_from_before.yaw_rad + turn_before_rad;
  return {map_from_before.translation +
              drive_m * Vec2{std::cos(course_rad), std::sin(course_rad)},
          NormalizedAngle_rad(course_rad + turn_after_rad)};
}

}  // namespace treeline
