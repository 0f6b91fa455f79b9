#include "nav_agent/core/slope_odometry.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "absl/strings/str_format.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"

namespace treeline::core {
namespace {

// No robot stands like that.
constexpr double kMaxTilt_rad = 1.0;
// A counter may jump by this much between two readings without a reset.
constexpr double kJump_m = 0.05;

geometry::Rotation3 Tilted(double pitch_rad, double roll_rad) {
  return geometry::Rotation3::FromAxisAngle({0, pitch_rad, 0}) *
         geometry::Rotation3::FromAxisAngle({roll_rad, 0, 0});
}

absl::Status Check(const BaseReading& reading) {
  for (const double value :
       {reading.left_wheel_m, reading.right_wheel_m, reading.yaw_rate_radps,
        reading.pitch_rad, reading.roll_rad}) {
    if (!std::isfinite(value)) {
      return absl::InvalidArgumentError("a wheel reading that is not finite");
    }
  }
  if (std::abs(reading.pitch_rad) > kMaxTilt_rad ||
      std::abs(reading.roll_rad) > kMaxTilt_rad) {
    return absl::InvalidArgumentError(
        absl::StrFormat("a wheel reading with a pitch of %.2f rad and a roll "
                        "of %.2f rad: the robot lies on its side",
                        reading.pitch_rad, reading.roll_rad));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status SlopeOdometryOptions::Validate() const {
  TL_RETURN_IF_ERROR(
      base::CheckRange("wheel_track_m", wheel_track_m, 0.05, 10));
  TL_RETURN_IF_ERROR(
      base::CheckRange("level_within_rad", level_within_rad, 0, 0.2));
  TL_RETURN_IF_ERROR(base::CheckRange("bias_time_s", bias_time_s, 1e-3, 1e6));
  TL_RETURN_IF_ERROR(base::CheckRange("max_bias_rad", max_bias_rad, 0, 0.2));
  TL_RETURN_IF_ERROR(base::CheckRange("max_gap_s", max_gap_s, 1e-3, 10));
  return base::CheckRange("max_speed_mps", max_speed_mps, 0.1, 100);
}

absl::StatusOr<SlopeOdometry> SlopeOdometry::Create(
    const SlopeOdometryOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  return SlopeOdometry(options);
}

void SlopeOdometry::Follow(Tilt& tilt, double measured_rad,
                           double interval_s) const {
  const double corrected_rad = measured_rad - tilt.bias_rad;
  if (std::abs(corrected_rad) >= options_.level_within_rad) {
    tilt.angle_rad = corrected_rad;
    return;
  }
  // The mean of all at first, later of the last bias_time_s.
  ++tilt.level_readings;
  const double share =
      std::clamp(interval_s / options_.bias_time_s,
                 1.0 / static_cast<double>(tilt.level_readings), 1.0);
  tilt.bias_rad = std::clamp(tilt.bias_rad + share * corrected_rad,
                             -options_.max_bias_rad, options_.max_bias_rad);
  tilt.angle_rad = 0;
}

absl::Status SlopeOdometry::Add(const BaseReading& reading) {
  TL_RETURN_IF_ERROR(Check(reading));
  if (!has_reading_) {
    has_reading_ = true;
    last_ = reading;
    Follow(pitch_, reading.pitch_rad, 0);
    Follow(roll_, reading.roll_rad, 0);
    return absl::OkStatus();
  }
  const double interval_s =
      std::chrono::duration<double>(reading.stamp - last_.stamp).count();
  if (interval_s < 0) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "the clock of wheel readings jumped back by %.3f s", -interval_s));
  }
  double left_m = reading.left_wheel_m - last_.left_wheel_m;
  double right_m = reading.right_wheel_m - last_.right_wheel_m;
  const double max_m = options_.max_speed_mps * interval_s + kJump_m;
  if (std::abs(left_m) > max_m || std::abs(right_m) > max_m) {
    ++resets_;
    left_m = 0;
    right_m = 0;
  }
  double turn_rad = (right_m - left_m) / options_.wheel_track_m;
  const bool stands = left_m == 0 && right_m == 0;
  if (options_.uses_yaw_rate && interval_s <= options_.max_gap_s && !stands) {
    turn_rad =
        0.5 * (last_.yaw_rate_radps + reading.yaw_rate_radps) * interval_s;
  }
  const double pitch_before_rad = pitch_.angle_rad;
  const double roll_before_rad = roll_.angle_rad;
  Follow(pitch_, reading.pitch_rad, interval_s);
  Follow(roll_, reading.roll_rad, interval_s);
  last_ = reading;

  const geometry::Rotation3 tilt =
      Tilted(0.5 * (pitch_before_rad + pitch_.angle_rad),
             0.5 * (roll_before_rad + roll_.angle_rad));
  const double forward_m = 0.5 * (left_m + right_m);
  way_m_ += std::abs(forward_m);
  const double half_rad = 0.5 * turn_rad;
  const double chord_m = std::abs(half_rad) < 1e-6
                             ? forward_m
                             : forward_m * std::sin(half_rad) / half_rad;
  const geometry::Rotation3 heading =
      geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad_});
  position_m_ =
      position_m_ +
      heading * (tilt * geometry::Vec3{chord_m * std::cos(half_rad),
                                       chord_m * std::sin(half_rad), 0});
  const geometry::Vec3 ahead =
      tilt * geometry::Vec3{std::cos(turn_rad), std::sin(turn_rad), 0};
  yaw_rad_ =
      geometry::NormalizedAngle_rad(yaw_rad_ + std::atan2(ahead.y, ahead.x));
  return absl::OkStatus();
}

geometry::Rotation3 SlopeOdometry::LevelFromBase() const {
  return Tilted(pitch_.angle_rad, roll_.angle_rad);
}

geometry::Rigid3 SlopeOdometry::OdomFromBase() const {
  return {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad_}) *
                      LevelFromBase(),
          .translation = position_m_};
}

}  // namespace treeline::core
