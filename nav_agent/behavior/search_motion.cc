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
  move_held_at_.reset();
  has_backed_up_ = false;
  ordered_.reset();
}

void SearchMotion::GoTo(double yaw_in_odom_rad, double way_m, double move_mps,
                        const localization::TrackedMotion& motion,
                        base::MonotonicTime now) {
  ordered_ = {.yaw_rad = yaw_in_odom_rad, .way_m = way_m, .move_mps = move_mps};
  has_backed_up_ = false;
  NextLeg(Leg::kFace, motion, now);
}

void SearchMotion::EndWay(const localization::TrackedMotion& motion,
                          base::MonotonicTime now) {
  ordered_.reset();
  best_free_m_ = 0;
  has_backed_up_ = false;
  NextLeg(Leg::kTurn, motion, now);
}

void SearchMotion::NextLeg(Leg leg, const localization::TrackedMotion& motion,
                           base::MonotonicTime now) {
  leg_ = leg;
  leg_since_ = now;
  leg_from_ = motion.odom_from_base;
  held_since_.reset();
  turned_rad_ = 0;
}

bool SearchMotion::IsHeld(bool moves, base::MonotonicTime now) {
  if (moves) {
    held_since_.reset();
  } else if (!held_since_.has_value()) {
    held_since_ = now;
  }
  return held_since_.has_value() &&
         base::SecondsBetween(*held_since_, now) > kTurnStart_s;
}

bool SearchMotion::WasHeldHere(
    const localization::TrackedMotion& motion) const {
  if (!move_held_at_.has_value()) return false;
  const geometry::Rigid2& here = motion.odom_from_base;
  return geometry::Norm(here.translation - move_held_at_->translation) <
             kHeldPlace_m &&
         std::abs(geometry::NormalizedAngle_rad(
             here.yaw_rad - move_held_at_->yaw_rad)) < kCameFrom_rad;
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
      return {.wanted = Face(motion, input, speeds.turn_radps)};
    case Leg::kBackUp:
      return {.wanted = BackUp(motion, input.now)};
    case Leg::kMove:
      break;
  }
  return Move(motion, input, speeds.move_mps);
}

SearchMotion::Result SearchMotion::Turn(
    const localization::TrackedMotion& motion, const RelocalizationInput& input,
    const SearchSpeeds& speeds, SwingMotion& swing) {
  const double yaw_rad = motion.odom_from_base.yaw_rad;
  const double back_rad = geometry::NormalizedAngle_rad(
      yaw_rad - leg_from_.yaw_rad - std::numbers::pi);
  const double worth =
      turns_ > 0 && std::abs(back_rad) < kCameFrom_rad ? kKnownWorth : 1.0;
  if (!WasHeldHere(motion) && worth * input.free_ahead_m > best_free_m_) {
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
    const localization::TrackedMotion& motion, const RelocalizationInput& input,
    double turn_radps) {
  const bool has_way =
      ordered_.has_value() || best_free_m_ >= 2 * kMinSearchMove_m;
  const double yaw_rad =
      ordered_.has_value() ? ordered_->yaw_rad : best_free_yaw_rad_;
  const double left_rad =
      geometry::NormalizedAngle_rad(yaw_rad - motion.odom_from_base.yaw_rad);
  const bool is_held =
      IsHeld(std::abs(motion.yaw_rate_radps) > kHeldTurn_radps, input.now);
  if ((is_held || !has_way) && BacksUp(motion, input)) return {};
  if (is_held && has_way && GoesAhead(motion, input)) return {};
  if (!has_way || is_held || IsStuck(input.now)) {
    EndWay(motion, input.now);
    return {};
  }
  if (std::abs(left_rad) > kTurnTolerance_rad) {
    return TurnTowards(yaw_rad, motion, turn_radps);
  }
  leg_m_ =
      ordered_.has_value() ? ordered_->way_m : best_free_m_ - kMinSearchMove_m;
  NextLeg(Leg::kMove, motion, input.now);
  return {};
}

bool SearchMotion::BacksUp(const localization::TrackedMotion& motion,
                           const RelocalizationInput& input) {
  if (has_backed_up_ || input.free_behind_m < kMinBackUp_m) return false;
  has_backed_up_ = true;
  leg_m_ = input.free_behind_m;
  NextLeg(Leg::kBackUp, motion, input.now);
  return true;
}

bool SearchMotion::GoesAhead(const localization::TrackedMotion& motion,
                             const RelocalizationInput& input) {
  if (input.free_ahead_m < kMinSearchMove_m + kMinBackUp_m) return false;
  ordered_.reset();
  leg_m_ =
      std::min<double>(kMinSearchMove_m, input.free_ahead_m - kMinSearchMove_m);
  NextLeg(Leg::kMove, motion, input.now);
  return true;
}

core::VelocityCommand SearchMotion::BackUp(
    const localization::TrackedMotion& motion, base::MonotonicTime now) {
  const double moved_m =
      geometry::Norm(motion.odom_from_base.translation - leg_from_.translation);
  if (moved_m >= leg_m_ - kBackUpTolerance_m ||
      base::SecondsBetween(leg_since_, now) > kMaxBackUp_s) {
    NextLeg(Leg::kFace, motion, now);
    return {};
  }
  return {.forward_mps = -kBackUp_mps, .yaw_rate_radps = 0};
}

SearchMotion::Result SearchMotion::Move(
    const localization::TrackedMotion& motion, const RelocalizationInput& input,
    double move_mps) {
  const double moved_m =
      geometry::Norm(motion.odom_from_base.translation - leg_from_.translation);
  const bool is_there = moved_m >= leg_m_;
  const bool is_held =
      IsHeld(motion.forward_mps > kStandstillSpeed_mps, input.now);
  if (is_held) move_held_at_ = motion.odom_from_base;
  if (is_there || is_held || input.free_ahead_m < kMinSearchMove_m ||
      IsStuck(input.now)) {
    EndWay(motion, input.now);
    return {.wanted = {}, .has_arrived = true, .was_blocked = !is_there};
  }
  return {.wanted = {.forward_mps =
                         ordered_.has_value() ? ordered_->move_mps : move_mps,
                     .yaw_rate_radps = 0}};
}

}  // namespace treeline::behavior
