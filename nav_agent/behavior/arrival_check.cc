#include "nav_agent/behavior/arrival_check.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/angle_text.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/pose_lists.h"

namespace treeline::behavior {

ArrivalCheck::Outcome ArrivalCheck::Step(
    const control::ControlPose& pose, const core::LevelPose& target,
    const control::LocalControllerOptions& tolerances,
    base::MonotonicTime now) {
  if (!since_.has_value()) since_ = now;
  const double waited_s = base::SecondsBetween(*since_, now);
  const bool is_there = Distance_m(pose.pose, target) <=
                            tolerances.goal_tolerance_m + kArrivalSlack_m &&
                        HeadingOff_rad(pose.pose, target) <=
                            tolerances.goal_tolerance_rad + kArrivalSlack_rad;
  const bool stands =
      std::abs(pose.forward_mps) < control::kStandingSpeed_mps &&
      std::abs(pose.yaw_rate_radps) < control::kStandingTurn_radps;
  if (is_there && stands) {
    return end_.is_goal_taken && waited_s < kGoalWait_s ? Outcome::kStands
                                                        : Outcome::kReached;
  }
  return waited_s > kArrivalDispute_s ? Outcome::kDisputed : Outcome::kOpen;
}

std::string ArrivalCheck::Text(const core::LevelPose& robot,
                               const core::LevelPose& target,
                               double driven_m) const {
  std::string text = absl::StrFormat(
      "%.2f m and %.0f degrees off, after %.1f m", Distance_m(robot, target),
      InDegrees(HeadingOff_rad(robot, target)), driven_m);
  if (end_.beside_goal_m > 0) {
    absl::StrAppendFormat(
        &text, ", at a place %.2f m beside the goal, %s", end_.beside_goal_m,
        end_.is_goal_taken ? "where something stands" : "which has no room");
  }
  return text;
}

}  // namespace treeline::behavior
