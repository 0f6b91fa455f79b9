#include "nav_agent/control/goal_approach.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace treeline::control {
namespace {

// Shares of the tolerances within which the robot is content.
constexpr double kContent = 0.35;
constexpr double kEnough = 0.75;
// Off the line to the goal by more, it turns first; until less (rad).
constexpr double kAlignFrom_rad = 0.5;
constexpr double kAlignUntil_rad = 0.1;

}  // namespace

bool GoalApproach::IsNear(const geometry::Rigid2& map_from_base,
                          const geometry::Rigid2& map_from_goal,
                          double left_m) {
  const double away_m =
      geometry::Norm(map_from_base.translation - map_from_goal.translation);
  if (phase_ == Phase::kFar && left_m < options_.near_m &&
      away_m < options_.near_m) {
    phase_ = Phase::kMove;
    aligns_ = false;
  }
  // Pushed away, or told another pose.
  if (phase_ != Phase::kFar && away_m > 2 * options_.near_m) {
    phase_ = Phase::kFar;
  }
  return phase_ != Phase::kFar;
}

core::VelocityCommand GoalApproach::Command(
    const geometry::Rigid2& map_from_base,
    const geometry::Rigid2& map_from_goal, const core::RobotModel& robot,
    const TrackFollowerOptions& options) {
  const geometry::Vec2 goal =
      map_from_base.Inverse() * map_from_goal.translation;
  const double away_m = geometry::Norm(goal);
  const double turn_rad = geometry::NormalizedAngle_rad(map_from_goal.yaw_rad -
                                                        map_from_base.yaw_rad);
  if (phase_ == Phase::kMove) {
    // Abeam of the goal nothing is gained by driving on.
    const bool is_abeam =
        std::abs(goal.x) < 0.02 && away_m < kEnough * options_.tolerance_m;
    if (away_m < kContent * options_.tolerance_m || is_abeam) {
      phase_ = Phase::kTurn;
    }
  } else if (away_m > 0.95 * options_.tolerance_m) {
    phase_ = Phase::kMove;
    aligns_ = true;
  }
  if (phase_ == Phase::kMove) {
    const double sign = goal.x >= 0 ? 1 : -1;
    const double off_rad = std::atan2(sign * goal.y, sign * goal.x);
    if (std::abs(off_rad) > kAlignFrom_rad) aligns_ = true;
    if (std::abs(off_rad) < kAlignUntil_rad) aligns_ = false;
    if (aligns_) {
      return {.forward_mps = 0,
              .yaw_rate_radps = TurnRate_radps(off_rad, robot, options)};
    }
    const double brake = 0.5 * robot.max_deceleration_mps2;
    const double speed =
        std::min({0.25, std::sqrt(2 * brake * away_m), 2.0 * away_m + 0.02});
    return {.forward_mps = sign * speed,
            .yaw_rate_radps = std::clamp(2.0 * off_rad, -0.6, 0.6)};
  }
  if (phase_ == Phase::kTurn &&
      std::abs(turn_rad) < kContent * options_.tolerance_rad) {
    phase_ = Phase::kDone;
  }
  if (phase_ == Phase::kDone &&
      std::abs(turn_rad) > 0.95 * options_.tolerance_rad) {
    phase_ = Phase::kTurn;
  }
  if (phase_ == Phase::kDone) return {};
  return {.forward_mps = 0,
          .yaw_rate_radps = TurnRate_radps(turn_rad, robot, options)};
}

}  // namespace treeline::control
