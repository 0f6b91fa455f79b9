#include "nav_agent/behavior/goal_executor.h"

#include <type_traits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nav_agent/behavior/place_text.h"
#include "nav_agent/behavior/pose_lists.h"

namespace treeline::behavior {

NavigatorMode ModeOf(GoalPhase phase) {
  switch (phase) {
    case GoalPhase::kToPlan:
    case GoalPhase::kPlanning:
      return NavigatorMode::kPlanning;
    case GoalPhase::kDriving:
      return NavigatorMode::kDriving;
    case GoalPhase::kRecovering:
      return NavigatorMode::kRecovering;
    case GoalPhase::kNone:
      break;
  }
  return NavigatorMode::kIdle;
}

GoalExecutor::GoalExecutor(
    std::shared_ptr<const traversability::NavigationMap> map,
    PlannerWorker& planner, control::LocalController& controller,
    const NavigatorOptions& options, EventLog& events)
    : tools_(std::move(map), planner, controller, options, events) {}

GoalPhase GoalExecutor::phase() const {
  static_assert(
      std::is_same_v<std::variant_alternative_t<
                         static_cast<size_t>(GoalPhase::kRecovering), State>,
                     RecoveringState>);
  return static_cast<GoalPhase>(state_.index());
}

std::optional<GoalStatus> GoalExecutor::status() const {
  if (!goal_.has_value()) return std::nullopt;
  return goal_->status;
}

bool GoalExecutor::DrivesStraight() const {
  const auto* driving = std::get_if<DrivingState>(&state_);
  return driving != nullptr && driving->DrivesStraight();
}

core::NavigationCause GoalExecutor::trouble() const {
  if (const auto* driving = std::get_if<DrivingState>(&state_);
      driving != nullptr && driving->WaitsAtGoal()) {
    return core::NavigationCause::kGoalBlocked;
  }
  const auto* recovering = std::get_if<RecoveringState>(&state_);
  return recovering == nullptr ? core::NavigationCause::kNone
                               : recovering->trouble().cause;
}

// ---- from outside ----

uint64_t GoalExecutor::Start(const NavigationGoal& goal) {
  End({.state = GoalState::kCancelled,
       .cause = core::NavigationCause::kPreempted,
       .why = "another goal took its place"});
  goal_ = GoalCourse{.goal = goal, .status = {}};
  std::vector<core::LevelPose>& poses = goal_->goal.poses;
  for (core::LevelPose& pose : poses) {
    const std::optional<core::LevelPlace> ground =
        tools_.map->GroundOf(pose.map_from_base.translation, pose.place.level);
    if (ground.has_value()) pose.place = *ground;
  }
  HeadAlong(poses);
  goal_->status.id = ++last_id_;
  state_ = ToPlanState();
  has_told_of_gone_ = false;
  tools_.progress.Reset();
  tools_.attempts.Refill();
  tools_.occupied.Reset();
  tools_.events.Add("goal",
                    absl::StrFormat("goal %d accepted: %s, %d poses", last_id_,
                                    PlaceText(poses.back()), poses.size()));
  return last_id_;
}

void GoalExecutor::End(const GoalEnd& end) {
  if (!is_active()) return;
  Suspend();
  state_ = NoGoalState();
  GoalStatus& status = goal_->status;
  status.state = end.state;
  status.cause = end.cause;
  status.why = end.why;
  const char* what = end.state == GoalState::kSucceeded   ? "reached"
                     : end.state == GoalState::kCancelled ? "given up"
                                                          : "failed";
  std::string text = absl::StrFormat("goal %d %s", status.id, what);
  if (end.cause != core::NavigationCause::kNone) {
    absl::StrAppend(&text, " (", core::NavigationCauseName(end.cause), ")");
  }
  tools_.events.Add("goal", absl::StrCat(text, ": ", end.why));
}

void GoalExecutor::Suspend() {
  tools_.plans.Cancel();
  tools_.controller.SetPath({});
  tools_.route.path.clear();
  tools_.progress.Restart();
  travel_.Restart();
  if (is_active()) state_ = ToPlanState();
}

void GoalExecutor::SetZones(std::shared_ptr<const zones::ZoneMap> zones) {
  tools_.controller.SetZones(zones);
  tools_.plans.SetZones(std::move(zones));
  Suspend();
  if (!is_active()) return;
  // Zones that leave no way are no trouble that recoveries help against.
  goal_->is_first_path = true;
  tools_.attempts.Refill();
}

void GoalExecutor::NoteWayIsFree() {
  if (auto* driving = std::get_if<DrivingState>(&state_)) {
    driving->NoteWayIsFree();
  } else if (auto* planning = std::get_if<PlanningState>(&state_)) {
    planning->NoteWayIsFree();
  } else if (auto* recovering = std::get_if<RecoveringState>(&state_)) {
    recovering->NoteWayIsFree();
  }
}

// ---- one step ----

core::VelocityCommand GoalExecutor::Step(const control::ControlPose& pose,
                                         base::MonotonicTime now) {
  if (!is_active()) return tools_.controller.Guard(pose, {});
  LookThroughMap();
  goal_->status.state = GoalState::kActive;
  goal_->status.driven_m += travel_.Step_m(pose.pose.map_from_base.translation);
  if (phase() == GoalPhase::kToPlan) {
    state_ = PlanningState(*goal_, pose.pose, tools_, now);
  }
  if (phase() == GoalPhase::kPlanning) StepPlanning(pose.pose, now);
  if (phase() == GoalPhase::kRecovering) return StepRecovering(pose, now);
  if (phase() == GoalPhase::kDriving) return StepDriving(pose, now);
  return tools_.controller.Guard(pose, {});
}

void GoalExecutor::LookThroughMap() {
  std::shared_ptr<const traversability::FreedCells> freed =
      tools_.controller.Freed();
  const bool is_any = freed != nullptr;
  if (!tools_.plans.SetFreed(std::move(freed)) || !is_any) return;
  if (!std::exchange(has_told_of_gone_, true)) {
    tools_.events.Add("map",
                      "something that the map has is not there any more");
  }
  NoteWayIsFree();
}

void GoalExecutor::StepPlanning(const core::LevelPose& robot,
                                base::MonotonicTime now) {
  PlanningState::Outcome outcome =
      std::get<PlanningState>(state_).Step(*goal_, robot, tools_, now);
  if (const auto* path = std::get_if<PlannedPath>(&outcome)) {
    const bool is_first = std::exchange(goal_->is_first_path, false);
    if (!is_first) ++goal_->status.replans;
    state_ =
        DrivingState(*path, is_first ? "a way" : "another way", *goal_, tools_);
  } else if (auto* trouble = std::get_if<GoalTrouble>(&outcome)) {
    Recover(std::move(*trouble), now);
  } else if (const auto* end = std::get_if<GoalEnd>(&outcome)) {
    End(*end);
  }
}

core::VelocityCommand GoalExecutor::StepDriving(
    const control::ControlPose& pose, base::MonotonicTime now) {
  DrivingState::Result step =
      std::get<DrivingState>(state_).Step(pose, *goal_, tools_, now);
  if (std::holds_alternative<DrivingState::NeedsPlan>(step.outcome)) {
    tools_.plans.Cancel();
    state_ = ToPlanState();
  } else if (std::holds_alternative<DrivingState::PassedPose>(step.outcome)) {
    NextLeg(pose.pose);
    // The controller has not seen the path of the next leg yet.
    if (phase() == GoalPhase::kDriving) return {};
  } else if (auto* trouble = std::get_if<GoalTrouble>(&step.outcome)) {
    Recover(std::move(*trouble), now);
  } else if (const auto* end = std::get_if<GoalEnd>(&step.outcome)) {
    ++goal_->status.next_pose;
    End(*end);
  }
  return is_active() ? step.command : core::VelocityCommand{};
}

void GoalExecutor::NextLeg(const core::LevelPose& robot) {
  GoalStatus& status = goal_->status;
  ++status.next_pose;
  tools_.events.Add(
      "goal", absl::StrFormat("goal %d: pose %d of %d", status.id,
                              status.next_pose, goal_->goal.poses.size()));
  tools_.plans.Cancel();
  tools_.attempts.Refill();
  tools_.occupied.Reset();
  const std::optional<planning::PlanResult>& leg =
      std::get<DrivingState>(state_).next_leg();
  if (!leg.has_value()) {
    goal_->is_first_path = true;
    state_ = ToPlanState();
    return;
  }
  const PlannedPath path = {.result = JoinLeg(tools_.route.path, robot, *leg),
                            .had_blockages = !tools_.blockages.empty(),
                            .may_be_better = false};
  state_ = DrivingState(path, "the way on", *goal_, tools_);
}

// ---- recoveries ----

void GoalExecutor::Recover(GoalTrouble trouble, base::MonotonicTime now) {
  tools_.plans.Cancel();
  state_ = RecoveringState(std::move(trouble));
  NextManeuver(now);
}

void GoalExecutor::NextManeuver(base::MonotonicTime now) {
  RecoveringState& recovering = std::get<RecoveringState>(state_);
  if (recovering.BeginNext(tools_, now)) {
    ++goal_->status.recoveries;
    return;
  }
  const GoalTrouble& trouble = recovering.trouble();
  End({.state = GoalState::kFailed,
       .cause = trouble.cause,
       .why = absl::StrFormat("%s; %d recoveries did not help", trouble.why,
                              tools_.attempts.recoveries().used())});
}

core::VelocityCommand GoalExecutor::StepRecovering(
    const control::ControlPose& pose, base::MonotonicTime now) {
  const RecoveringState::Result step =
      std::get<RecoveringState>(state_).Step(pose, tools_, now);
  switch (step.outcome) {
    case RecoveringState::Outcome::kRuns:
      return step.command;
    case RecoveringState::Outcome::kDone:
      state_ = ToPlanState();
      break;
    case RecoveringState::Outcome::kNotPossible:
      NextManeuver(now);
      break;
  }
  return tools_.controller.Guard(pose, {});
}

}  // namespace treeline::behavior
