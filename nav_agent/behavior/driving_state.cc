#include "nav_agent/behavior/driving_state.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/angle_text.h"
#include "nav_agent/behavior/obstacle_discs.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/place_text.h"
#include "nav_agent/behavior/pose_lists.h"

namespace treeline::behavior {

DrivingState::DrivingState(const PlannedPath& plan, const char* what,
                           GoalCourse& goal, GoalTools& tools)
    : background_(plan.may_be_better), arrival_(PathEnd()) {
  Follow(plan, what, goal, tools);
}

void DrivingState::Follow(const PlannedPath& plan, const char* what,
                          GoalCourse& goal, GoalTools& tools) {
  const planning::PlanResult& way = plan.result;
  arrival_ = ArrivalCheck(
      {.beside_goal_m = way.moved_goal_m,
       .is_goal_taken =
           goal.IsLastLeg() && plan.had_blockages &&
           way.moved_goal_m > tools.options.control.goal_tolerance_m});
  control_ = {};
  control_.to_go_m = way.length_m;
  waiting_since_.reset();
  way_is_free_ = false;
  goal.status.to_go_m = way.length_m;
  tools.route.path = way.path;
  if (!way.tree_edges.empty()) tools.route.tree_edges = way.tree_edges;
  tools.controller.SetPath(way.path);
  tools.progress.Restart();
  std::string text = absl::StrFormat(
      "%s of %.1f m to %s, found in %.1f ms", what, way.length_m,
      PlaceText(way.path.back()), 1e3 * way.total_s);
  if (way.moved_goal_m > 0) {
    absl::StrAppendFormat(&text,
                          "; %.2f m beside the goal, where there is room",
                          way.moved_goal_m);
  }
  tools.events.Add("plan", std::move(text));
}

bool DrivingState::DrivesStraight() const {
  return control_.command.forward_mps > kStraightSpeed_mps &&
         std::abs(control_.command.yaw_rate_radps) < kStraightYawRate_radps;
}

DrivingState::Result DrivingState::Step(const control::ControlPose& pose,
                                        GoalCourse& goal, GoalTools& tools,
                                        base::MonotonicTime now) {
  const bool tries_again =
      arrival_.end().is_goal_taken ? way_is_free_ : waits_at_goal_;
  if (tries_again && tools.occupied.MayTry(now)) {
    return {.outcome = NeedsPlan(),
            .command = tools.controller.Guard(pose, {})};
  }
  if (waits_at_goal_ && !arrival_.end().is_goal_taken) {
    return {.outcome = GoesOn(), .command = tools.controller.Guard(pose, {})};
  }
  StepBackground(pose, goal, tools, now);
  control_ = tools.controller.Step(pose);
  goal.status.to_go_m = control_.to_go_m;
  const control::ControlState state = control_.state;
  if (state != control::ControlState::kWaiting) waiting_since_.reset();
  if (state != control::ControlState::kArrived) arrival_.Restart();
  Result result = {.outcome = GoesOn(), .command = control_.command};
  if (!goal.IsLastLeg() && PassesPose(pose.pose, tools)) {
    result.outcome = PassedPose();
    return result;
  }
  switch (state) {
    case control::ControlState::kIdle:
      result.outcome = NeedsPlan();
      break;
    case control::ControlState::kArrived:
      result.outcome = Arrive(pose, goal, tools, now);
      break;
    case control::ControlState::kBlocked:
      result.outcome =
          MeetObstacle(pose, "something stands in the way", goal, tools, now);
      break;
    case control::ControlState::kWaiting:
      result.outcome = Wait(pose, goal, tools, now);
      break;
    case control::ControlState::kDriving:
      result.outcome = CheckProgress(pose.pose, goal, tools, now);
      break;
  }
  return result;
}

void DrivingState::StepBackground(const control::ControlPose& pose,
                                  GoalCourse& goal, GoalTools& tools,
                                  base::MonotonicTime now) {
  const std::optional<PlannedPath> plan =
      background_.Step(goal, pose.pose, tools, now);
  if (!plan.has_value()) return;
  // To a goal that is taken leads none that is worth it.
  if (arrival_.end().is_goal_taken && !tools.occupied.MayTry(now)) return;
  const double from_m = Distance_m(plan->result.path.front(), pose.pose);
  if (from_m < kBetterPathStart_m &&
      from_m + plan->result.length_m <
          (1 - tools.options.limits.better_share) * control_.to_go_m) {
    Follow(*plan, "a shorter way", goal, tools);
  }
}

bool DrivingState::PassesPose(const core::LevelPose& robot,
                              const GoalTools& tools) const {
  if (control_.state == control::ControlState::kArrived) return true;
  const core::LevelPose& end = tools.route.path.back();
  return Distance_m(robot, end) <= tools.options.limits.waypoint_tolerance_m &&
         std::abs(robot.place.height_m - end.place.height_m) <
             localization::kFloorHeight_m;
}

DrivingState::Outcome DrivingState::Arrive(const control::ControlPose& pose,
                                           GoalCourse& goal, GoalTools& tools,
                                           base::MonotonicTime now) {
  const core::LevelPose& target = tools.route.path.back();
  switch (arrival_.Step(pose, target, tools.options.control, now)) {
    case ArrivalCheck::Outcome::kOpen:
      break;
    case ArrivalCheck::Outcome::kStands:
      goal.status.to_go_m = 0;
      waits_at_goal_ = true;
      if (tools.occupied.TellOnce()) {
        tools.events.Add(
            "goal",
            absl::StrFormat("waits %.2f m beside the goal, where something "
                            "stands",
                            arrival_.end().beside_goal_m));
      }
      break;
    case ArrivalCheck::Outcome::kReached:
      return EndAt(arrival_.Text(pose.pose, target, goal.status.driven_m),
                   goal);
    case ArrivalCheck::Outcome::kDisputed:
      if (tools.attempts.TakeReplan()) return NeedsPlan();
      return GoalTrouble{.kind = Trouble::kStuck,
                         .cause = core::NavigationCause::kNoProgress,
                         .why = "it does not come to stand at the goal"};
  }
  return GoesOn();
}

// As near as it could come; a place beside the goal is another one.
GoalEnd DrivingState::EndAt(std::string where, GoalCourse& goal) const {
  const double beside_m = arrival_.end().beside_goal_m;
  goal.status.to_go_m = beside_m;
  if (beside_m <= kPassPose_m) {
    return {.state = GoalState::kSucceeded,
            .cause = core::NavigationCause::kNone,
            .why = std::move(where)};
  }
  return {.state = GoalState::kFailed,
          .cause = core::NavigationCause::kGoalBlocked,
          .why = std::move(where)};
}

std::optional<DrivingState::Outcome> DrivingState::MeetAtGoal(
    const control::ControlPose& pose, const char* what, GoalCourse& goal,
    GoalTools& tools, base::MonotonicTime now) {
  const double beside_m = Distance_m(pose.pose, goal.Target());
  const bool has_time = tools.occupied.Meet(now);
  if (beside_m > kPassPose_m) return std::nullopt;
  if (!has_time) return EndBeside(pose.pose, what, goal, tools);
  waits_at_goal_ = true;
  if (tools.occupied.TellOnce()) {
    tools.events.Add("goal", absl::StrFormat("waits %.2f m beside the goal: %s",
                                             beside_m, what));
  }
  return GoesOn();
}

GoalEnd DrivingState::EndBeside(const core::LevelPose& robot, const char* what,
                                GoalCourse& goal, const GoalTools& tools) {
  const double beside_m = Distance_m(robot, goal.Target());
  const double off_rad = HeadingOff_rad(robot, goal.Target());
  goal.status.to_go_m = beside_m;
  const bool is_there =
      off_rad <= tools.options.control.goal_tolerance_rad + kArrivalSlack_rad;
  return {.state = is_there ? GoalState::kSucceeded : GoalState::kFailed,
          .cause = is_there ? core::NavigationCause::kNone
                            : core::NavigationCause::kGoalBlocked,
          .why = absl::StrFormat(
              "stopped %.2f m beside the goal and %.0f degrees off, after %.1f "
              "m: %s",
              beside_m, InDegrees(off_rad), goal.status.driven_m, what)};
}

DrivingState::Outcome DrivingState::Wait(const control::ControlPose& pose,
                                         GoalCourse& goal, GoalTools& tools,
                                         base::MonotonicTime now) {
  if (!waiting_since_.has_value()) {
    waiting_since_ = now;
    tools.events.Add("blocked", "waits for something that moves");
  }
  tools.progress.Restart();
  if (base::SecondsBetween(*waiting_since_, now) <=
      tools.options.limits.wait_for_moving_s) {
    return GoesOn();
  }
  return MeetObstacle(pose, "what moved does not go away", goal, tools, now);
}

DrivingState::Outcome DrivingState::MeetObstacle(
    const control::ControlPose& pose, const std::string& what, GoalCourse& goal,
    GoalTools& tools, base::MonotonicTime now) {
  const geometry::Vec2 obstacle = control_.obstacle_in_map;
  if (goal.IsLastLeg() &&
      geometry::Norm(obstacle - goal.Target().map_from_base.translation) <=
          kObstacleNear_m) {
    if (auto outcome =
            MeetAtGoal(pose, "something stands there", goal, tools, now)) {
      return *std::move(outcome);
    }
  }
  const std::optional<core::LevelPlace> ground =
      tools.map->GroundNear(obstacle, pose.pose.place.height_m);
  const NavigatorLimits& limits = tools.options.limits;
  for (const planning::Blockage& disc :
       DiscsOf(tools.controller.Costmap(), obstacle,
               pose.pose.map_from_base.translation, limits.blockage_margin_m,
               control_.obstacle_radius_m + limits.blockage_margin_m,
               ground.has_value() ? ground->level : pose.pose.place.level)) {
    tools.blockages.Add(disc, now);
  }
  tools.events.Add("blocked", absl::StrFormat("%s at (%.2f, %.2f)", what,
                                              obstacle.x, obstacle.y));
  if (tools.attempts.TakeReplan()) return NeedsPlan();
  return GoalTrouble{
      .kind = Trouble::kNoWay,
      .cause = core::NavigationCause::kBlocked,
      .why = absl::StrFormat("%d ways around what stands there are blocked",
                             limits.max_replans)};
}

DrivingState::Outcome DrivingState::CheckProgress(
    const core::LevelPose& robot, GoalCourse& goal, GoalTools& tools,
    base::MonotonicTime now) const {
  const bool gets_on =
      tools.progress.Observe(now, goal.status.next_pose, control_.to_go_m,
                             robot.map_from_base.yaw_rad);
  if (tools.progress.TakeRefill()) {
    tools.attempts.Refill();
    tools.occupied.Reset();
  }
  if (gets_on) return GoesOn();
  // A goal that recoveries did not help to turn at, and will not.
  if (goal.IsLastLeg() && Distance_m(robot, goal.Target()) <= kPassPose_m &&
      !tools.occupied.Meet(now)) {
    return EndBeside(robot, "there is no room to turn", goal, tools);
  }
  return GoalTrouble{.kind = Trouble::kStuck,
                     .cause = control_.is_stopped_by_guard
                                  ? core::NavigationCause::kCollisionStop
                                  : core::NavigationCause::kNoProgress,
                     .why = absl::StrFormat(
                         "%.1f m to go, and no nearer for %.0f s",
                         control_.to_go_m, tools.options.limits.progress_s)};
}

}  // namespace treeline::behavior
