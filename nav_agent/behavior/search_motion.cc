#include "nav_agent/behavior/search_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/base/clock.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_parts.h"

namespace treeline::behavior {

void SearchMotion::Begin(base::MonotonicTime now) {
  leg_ = Leg::kTurn;
  leg_since_ = now;
  turned_rad_ = 0;
  turns_ = 0;
  best_free_m_ = 0;
}

void SearchMotion::NextLeg(Leg leg, const localization::TrackedMotion& motion,
                           base::MonotonicTime now) {
  leg_ = leg;
  leg_since_ = now;
  leg_from_ = motion.odom_from_base;
  turned_rad_ = 0;
}

bool SearchMotion::IsStuck(base::MonotonicTime now) const {
  return base::SecondsBetween(leg_since_, now) > kMaxSearchLeg_s;
}

SearchMotion::Result SearchMotion::Step(
    const localization::TrackedMotion& motion, const RelocalizationInput& input,
    const SearchSpeeds& speeds, SwingMotion& swing) {
  switch (leg_) {
    case Leg::kTurn:
      return Turn(motion, input, speeds, swing);
    case Leg::kFace:
      return {.wanted = Face(motion, input.now, speeds.turn_radps)};
    case Leg::kMove:
      break;
  }
  return {.wanted = Move(motion, input, speeds.move_mps)};
}

SearchMotion::Result SearchMotion::Turn(
    const localization::TrackedMotion& motion, const RelocalizationInput& input,
    const SearchSpeeds& speeds, SwingMotion& swing) {
  const double yaw_rad = motion.odom_from_base.yaw_rad;
  const double back_rad = geometry::NormalizedAngle_rad(
      yaw_rad - leg_from_.yaw_rad - std::numbers::pi);
  const double worth =
      turns_ > 0 && std::abs(back_rad) < kCameFrom_rad ? kKnownWorth : 1.0;
  if (worth * input.free_ahead_m > best_free_m_) {
    best_free_m_ = worth * input.free_ahead_m;
    best_free_yaw_rad_ = yaw_rad;
  }
  if (turned_rad_ >= 2 * std::numbers::pi || IsStuck(input.now)) {
    NextLeg(Leg::kFace, motion, input.now);
    ++turns_;
    return {.wanted = {}, .has_turned_around = true};
  }
  return {.wanted =
              swing.Step(motion, input, speeds.turn_radps, speeds.move_mps)};
}

core::VelocityCommand SearchMotion::Face(
    const localization::TrackedMotion& motion, base::MonotonicTime now,
    double turn_radps) {
  if (best_free_m_ < 2 * kMinSearchMove_m || IsStuck(now)) {
    best_free_m_ = 0;
    NextLeg(Leg::kTurn, motion, now);
    return {};
  }
  if (std::abs(geometry::NormalizedAngle_rad(best_free_yaw_rad_ -
                                             motion.odom_from_base.yaw_rad)) >
      kTurnTolerance_rad) {
    return TurnTowards(best_free_yaw_rad_, motion, turn_radps);
  }
  leg_m_ = best_free_m_ - kMinSearchMove_m;
  NextLeg(Leg::kMove, motion, now);
  return {};
}

core::VelocityCommand SearchMotion::Move(
    const localization::TrackedMotion& motion, const RelocalizationInput& input,
    double move_mps) {
  const double moved_m =
      geometry::Norm(motion.odom_from_base.translation - leg_from_.translation);
  if (moved_m >= leg_m_ || input.free_ahead_m < kMinSearchMove_m ||
      IsStuck(input.now)) {
    best_free_m_ = 0;
    NextLeg(Leg::kTurn, motion, input.now);
    return {};
  }
  return {.forward_mps = move_mps, .yaw_rate_radps = 0};
}

}  // namespace treeline::behavior
