#include "nav_agent/control/approach_regulator.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/control/manoeuvre_parameters.h"
#include "nav_agent/control/turn_rate.h"

namespace treeline::control {

void ApproachRegulator::Regulate(const RegulatorInput& input,
                                 RegulatedVelocity& regulated) {
  const geometry::Rigid2& map_from_base = input.pose.pose.map_from_base;
  if (!input.goal.has_value() || !IsNear(map_from_base, *input.goal)) return;
  regulated.velocity = Command(map_from_base, input.goal->map_from_goal);
  regulated.is_near_goal = true;
  regulated.is_turning_at_goal = phase_ == Phase::kTurn;
  regulated.is_at_goal = phase_ == Phase::kDone;
}

bool ApproachRegulator::IsNear(const geometry::Rigid2& map_from_base,
                               const GoalAhead& goal) {
  const double away_m = geometry::Norm(map_from_base.translation -
                                       goal.map_from_goal.translation);
  if (phase_ == Phase::kFar && goal.left_m < kGoalNear_m &&
      away_m < kGoalNear_m) {
    phase_ = Phase::kMove;
    aligns_ = false;
  }
  // Pushed away, or told another pose.
  if (phase_ != Phase::kFar && away_m > 2 * kGoalNear_m) phase_ = Phase::kFar;
  return phase_ != Phase::kFar;
}

core::VelocityCommand ApproachRegulator::MoveTo(geometry::Vec2 goal_in_base) {
  const double away_m = geometry::Norm(goal_in_base);
  const double sign = goal_in_base.x >= 0 ? 1 : -1;
  const double off_rad =
      std::atan2(sign * goal_in_base.y, sign * goal_in_base.x);
  if (std::abs(off_rad) > kAlignFrom_rad) aligns_ = true;
  if (std::abs(off_rad) < kAlignUntil_rad) aligns_ = false;
  if (aligns_) {
    return {.forward_mps = 0,
            .yaw_rate_radps = TurnOnSpotRate_radps(off_rad, robot_)};
  }
  const double brake = kGoalBrakeShare * robot_.max_deceleration_mps2;
  const double speed =
      std::min({kGoalSpeed_mps.value, std::sqrt(2 * brake * away_m),
                kGoalGain_hz * away_m + kStandingSpeed_mps});
  return {.forward_mps = sign * speed,
          .yaw_rate_radps = std::clamp(kGoalGain_hz * off_rad, -kGoalTurn_radps,
                                       +kGoalTurn_radps)};
}

core::VelocityCommand ApproachRegulator::Command(
    const geometry::Rigid2& map_from_base,
    const geometry::Rigid2& map_from_goal) {
  const geometry::Vec2 goal =
      map_from_base.Inverse() * map_from_goal.translation;
  const double away_m = geometry::Norm(goal);
  const double turn_rad = geometry::NormalizedAngle_rad(map_from_goal.yaw_rad -
                                                        map_from_base.yaw_rad);
  if (phase_ == Phase::kMove) {
    // Abeam of the goal nothing is gained by driving on.
    const bool is_abeam = std::abs(goal.x) < kAbeam_m &&
                          away_m < kAbeamShare * options_.tolerance_m;
    if (away_m < kContentShare * options_.tolerance_m || is_abeam) {
      phase_ = Phase::kTurn;
    }
  } else if (away_m > kLeaveShare * options_.tolerance_m) {
    phase_ = Phase::kMove;
    aligns_ = true;
  }
  if (phase_ == Phase::kMove) return MoveTo(goal);
  if (phase_ == Phase::kTurn &&
      std::abs(turn_rad) < kContentShare * options_.tolerance_rad) {
    phase_ = Phase::kDone;
  }
  if (phase_ == Phase::kDone &&
      std::abs(turn_rad) > kLeaveShare * options_.tolerance_rad) {
    phase_ = Phase::kTurn;
  }
  if (phase_ == Phase::kDone) return {};
  return {.forward_mps = 0,
          .yaw_rate_radps = TurnOnSpotRate_radps(turn_rad, robot_)};
}

}  // namespace treeline::control
