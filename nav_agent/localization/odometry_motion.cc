#include "nav_agent/localization/odometry_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {

OdometryNoise OdometryNoise::Of(const core::MeasuredOdometryNoise& measured) {
  const OdometryNoise noise = {
      .turn_from_turn = kNoiseMargin * measured.turn_from_turn,
      .turn_from_drive = kNoiseMargin * measured.turn_from_drive,
      .drive_from_drive = kNoiseMargin * measured.drive_from_drive,
      .drive_from_turn = kNoiseMargin * measured.drive_from_turn};
  return noise.AtLeastUsual();
}

OdometryNoise OdometryNoise::AtLeastUsual() const {
  const OdometryNoise usual;
  return {
      .turn_from_turn = std::max(turn_from_turn, usual.turn_from_turn),
      .turn_from_drive = std::max(turn_from_drive, usual.turn_from_drive),
      .drive_from_drive = std::max(drive_from_drive, usual.drive_from_drive),
      .drive_from_turn = std::max(drive_from_turn, usual.drive_from_turn)};
}

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

OdometryMotion::OdometryMotion(const geometry::Rigid2& before_from_after,
                               const OdometryNoise& noise) {
  // Driving back is no half turn, but a way of less than nothing.
  const geometry::Vec2 way = before_from_after.translation;
  const double sign = way.x < 0 ? -1 : 1;
  if (geometry::Norm(way) < kMinCourse_m) {
    drive_m_ = way.x;
  } else {
    drive_m_ = sign * geometry::Norm(way);
    turn_before_rad_ = std::atan2(sign * way.y, sign * way.x);
  }
  turn_after_rad_ = geometry::NormalizedAngle_rad(before_from_after.yaw_rad -
                                                  turn_before_rad_);
  const double before_rad = std::abs(turn_before_rad_);
  const double after_rad = std::abs(turn_after_rad_);
  const double driven_m = std::abs(drive_m_);
  turn_before_sigma_rad_ =
      noise.turn_from_turn * before_rad + noise.turn_from_drive * driven_m;
  turn_after_sigma_rad_ =
      noise.turn_from_turn * after_rad + noise.turn_from_drive * driven_m;
  drive_sigma_m_ = noise.drive_from_drive * driven_m +
                   noise.drive_from_turn * (before_rad + after_rad);
}

geometry::Rigid2 OdometryMotion::Sample(const geometry::Rigid2& map_from_before,
                                        base::Random& random) const {
  const double turn_before_rad =
      turn_before_rad_ + turn_before_sigma_rad_ * random.NextGaussian();
  const double drive_m = drive_m_ + drive_sigma_m_ * random.NextGaussian();
  const double turn_after_rad =
      turn_after_rad_ + turn_after_sigma_rad_ * random.NextGaussian();
  const double course_rad = map_from_before.yaw_rad + turn_before_rad;
  return {
      map_from_before.translation +
          drive_m * geometry::Vec2{std::cos(course_rad), std::sin(course_rad)},
      geometry::NormalizedAngle_rad(course_rad + turn_after_rad)};
}

}  // namespace treeline::localization
