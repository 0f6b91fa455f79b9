#include "nav_agent/behavior/recovering_state.h"

#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {
namespace {

// Of a robot that is to take another way.
planning::Blockage Ahead(const core::LevelPose& robot) {
  return {.center = robot.map_from_base * geometry::Vec2{kRerouteAhead_m, 0},
          .radius_m = kRerouteRadius_m,
          .level = robot.place.level};
}

}  // namespace

bool RecoveringState::BeginNext(GoalTools& tools, base::MonotonicTime now) {
  const std::optional<RecoverySequenceStep> rung =
      tools.attempts.recoveries().Next(trouble_.kind);
  if (!rung.has_value()) return false;
  maneuver_.emplace(*rung, tools.options.limits, now);
  maneuver_since_ = now;
  way_is_free_ = false;
  tools.events.Add(
      "recovery",
      absl::StrFormat("%s (%s: %s)", RecoveryBehaviorName(rung->kind),
                      core::NavigationCauseName(trouble_.cause), trouble_.why));
  return true;
}

RecoveringState::Result RecoveringState::Step(const control::ControlPose& pose,
                                              GoalTools& tools,
                                              base::MonotonicTime now) {
  const RecoveryBehaviorKind kind = maneuver_->kind();
  if (way_is_free_ && kind == RecoveryBehaviorKind::kWait &&
      base::SecondsBetween(maneuver_since_, now) > kMinWait_s) {
    tools.attempts.recoveries().GiveBack();
    return {.outcome = Outcome::kDone, .command = {}};
  }
  const RecoveryBehavior::Result result =
      maneuver_->Step(pose, now, tools.controller);
  if (result.outcome == RecoveryBehaviorOutcome::kRunning) {
    return {.outcome = Outcome::kRuns, .command = result.command};
  }
  if (kind == RecoveryBehaviorKind::kReroute) {
    tools.blockages.Add(Ahead(pose.pose), now);
  }
  tools.events.Add(
      "recovery", absl::StrFormat("%s: %s", RecoveryBehaviorName(kind),
                                  RecoveryBehaviorOutcomeName(result.outcome)));
  const bool is_next_due =
      result.outcome == RecoveryBehaviorOutcome::kNotPossible && !way_is_free_;
  return {.outcome = is_next_due ? Outcome::kNotPossible : Outcome::kDone,
          .command = {}};
}

}  // namespace treeline::behavior
