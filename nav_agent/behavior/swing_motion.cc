#include "nav_agent/behavior/swing_motion.h"

#include <algorithm>
#include <cmath>

#include "common/base/clock.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_parts.h"

namespace treeline::behavior {

core::VelocityCommand TurnTowards(double yaw_in_odom_rad,
                                  const localization::TrackedMotion& motion,
                                  double max_radps) {
  const double left_rad = geometry::NormalizedAngle_rad(
      yaw_in_odom_rad - motion.odom_from_base.yaw_rad);
  const double speed_radps = std::clamp(kTurnGain_per_s * std::abs(left_rad),
                                        kMinTurnSpeed_radps.value, max_radps);
  return {.forward_mps = 0,
          .yaw_rate_radps = std::copysign(speed_radps, left_rad)};
}

core::VelocityCommand SwingMotion::Step(
    const localization::TrackedMotion& motion, const RelocalizationInput& input,
    double turn_radps, double move_mps) {
  const auto held_on_this_side = [this]() -> std::optional<geometry::Rigid2>& {
    return held_at_[side_ > 0 ? 1 : 0];
  };
  // Also what the laser does not see may hold it.
  if (std::abs(motion.yaw_rate_radps) > kHeldTurn_radps) {
    blocked_since_.reset();
    sides_blocked_ = 0;
  } else if (!blocked_since_.has_value()) {
    blocked_since_ = input.now;
  } else if (base::SecondsBetween(*blocked_since_, input.now) >
             kSwingBlocked_s) {
    held_on_this_side() = motion.odom_from_base;
    side_ = -side_;
    blocked_since_.reset();
    ++sides_blocked_;
  }
  // Once is enough.
  if (const std::optional<geometry::Rigid2>& held = held_on_this_side();
      held.has_value() &&
      geometry::Norm(held->translation - motion.odom_from_base.translation) <
          kHeldPlace_m) {
    const double left_rad =
        side_ * geometry::NormalizedAngle_rad(held->yaw_rad -
                                              motion.odom_from_base.yaw_rad);
    if (left_rad > 0 && left_rad < kHeldMargin_rad) side_ = -side_;
  }
  // Ahead it sees where it goes; behind it does not.
  if (sides_blocked_ >= 2 && input.free_ahead_m >= kMinFreeAhead_m) {
    if (sides_blocked_ < kMaxSidesBlocked) {
      return {.forward_mps = move_mps, .yaw_rate_radps = 0};
    }
    sides_blocked_ = 0;
  }
  return {.forward_mps = 0, .yaw_rate_radps = side_ * turn_radps};
}

}  // namespace treeline::behavior
