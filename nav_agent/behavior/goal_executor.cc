#include "nav_agent/behavior/goal_executor.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "common/base/random.h"
#include "nav_agent/behavior/angle_text.h"
#include "nav_agent/behavior/obstacle_discs.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/pose_lists.h"

namespace treeline::behavior {
namespace {

std::string Place(const core::LevelPose& pose) {
  return absl::StrFormat("(%.2f, %.2f) on level %d",
                         pose.map_from_base.translation.x,
                         pose.map_from_base.translation.y, pose.place.level);
}

}  // namespace

GoalExecutor::GoalExecutor(
    std::shared_ptr<const traversability::NavigationMap> map,
    PlannerWorker& planner, control::LocalController& controller,
    const NavigatorOptions& options, EventLog& events)
    : map_(std::move(map)),
      planner_(&planner),
      controller_(&controller),
      options_(options),
      events_(&events),
      progress_(options.limits),
      blockages_(options.limits),
      ladder_(options.limits) {}

uint64_t GoalExecutor::Start(const NavigationGoal& goal) {
  End(GoalState::kCancelled, core::NavigationCause::kPreempted,
      "another goal took its place");
  goal_ = goal;
  for (core::LevelPose& pose : goal_.poses) {
    const std::optional<core::LevelPlace> ground =
        map_->GroundOf(pose.map_from_base.translation, pose.place.level);
    if (ground.has_value()) pose.place = *ground;
  }
  HeadAlong(goal_.poses);
  status_.emplace();
  status_->id = ++last_id_;
  phase_ = GoalPhase::kToPlan;
  is_first_path_ = true;
  replans_ = 0;
  progress_.Reset();
  ladder_.Refill();
  events_->Add("goal",
               absl::StrFormat("goal %d accepted: %s, %d poses", status_->id,
                               Place(goal_.poses.back()), goal_.poses.size()));
  return status_->id;
}

void GoalExecutor::End(GoalState state, core::NavigationCause cause,
                       const std::string& why) {
  if (!is_active()) return;
  Suspend();
  phase_ = GoalPhase::kNone;
  status_->state = state;
  status_->cause = cause;
  status_->why = why;
  const char* what = state == GoalState::kSucceeded   ? "reached"
                     : state == GoalState::kCancelled ? "given up"
                                                      : "failed";
  std::string text = absl::StrFormat("goal %d %s", status_->id, what);
  if (cause != core::NavigationCause::kNone) {
    absl::StrAppend(&text, " (", core::NavigationCauseName(cause), ")");
  }
  events_->Add("goal", absl::StrCat(text, ": ", why));
}

void GoalExecutor::Suspend() {
  planner_->Cancel();
  asked_.reset();
  controller_->SetPath({});
  path_.clear();
  control_ = {};
  next_leg_.reset();
  maneuver_.reset();
  waiting_since_.reset();
  arrived_since_.reset();
  last_position_.reset();
  progress_.Restart();
  trouble_cause_ = core::NavigationCause::kNone;
  if (is_active()) phase_ = GoalPhase::kToPlan;
}

void GoalExecutor::NoteWayIsFree() { way_is_free_ = true; }

bool GoalExecutor::DrivesStraight() const {
  return phase_ == GoalPhase::kDriving &&
         control_.command.forward_mps > kStraightSpeed_mps &&
         std::abs(control_.command.yaw_rate_radps) < kStraightYawRate_radps;
}

core::VelocityCommand GoalExecutor::Step(const control::ControlPose& pose,
                                         base::MonotonicTime now) {
  if (!is_active()) return controller_->Guard(pose, {});
  status_->state = GoalState::kActive;
  Measure(pose);
  if (phase_ == GoalPhase::kToPlan) {
    Ask(PlanPurpose::kRoute, pose.pose, Target(), now);
    phase_ = GoalPhase::kPlanning;
  }
  if (phase_ == GoalPhase::kPlanning) StepPlanning(pose, now);
  if (phase_ == GoalPhase::kRecovering) return StepManeuver(pose, now);
  if (phase_ == GoalPhase::kDriving) return StepDriving(pose, now);
  return controller_->Guard(pose, {});
}

void GoalExecutor::Measure(const control::ControlPose& pose) {
  const geometry::Vec2 here = pose.pose.map_from_base.translation;
  if (last_position_.has_value()) {
    const double way_m = geometry::Norm(here - *last_position_);
    if (way_m < kMaxStepMove_m) status_->driven_m += way_m;
  }
  last_position_ = here;
}

// ---- planning ----

void GoalExecutor::Ask(PlanPurpose purpose, const core::LevelPose& from,
                       const core::LevelPose& to, base::MonotonicTime now) {
  planning::PlanRequest request = {
      .start = from,
      .goal = to,
      .blockages = {},
      .seed = base::MixBits(options_.seed + ++plans_)};
  if (purpose != PlanPurpose::kUnblocked) request.blockages = blockages_.All();
  const bool is_quick =
      purpose == PlanPurpose::kRoute || purpose == PlanPurpose::kUnblocked;
  planning::PlanBudget budget =
      is_quick ? options_.first_plan_budget : options_.plan_budget;
  if (purpose == PlanPurpose::kUnblocked) budget.improves = false;
  planner_->Start(request, budget);
  asked_ = AskedPlan{.purpose = purpose,
                     .since = now,
                     .has_blockages = !request.blockages.empty()};
}

void GoalExecutor::StepPlanning(const control::ControlPose& pose,
                                base::MonotonicTime now) {
  // A plan that fails may ask for another one, which may be there at once.
  for (int asked = 0;
       asked < kMaxPlanQuestions && phase_ == GoalPhase::kPlanning; ++asked) {
    std::optional<absl::StatusOr<planning::PlanResult>> result =
        planner_->Take();
    if (!result.has_value()) {
      if (base::SecondsBetween(asked_->since, now) < options_.limits.plan_s)
        return;
      planner_->Cancel();
      planning::PlanResult late;
      late.failure = core::NavigationCause::kPlanTimeout;
      late.why = "the planner did not come to an end";
      result = std::move(late);
    }
    if (!result->ok()) {
      End(GoalState::kFailed, core::NavigationCause::kInternal,
          absl::StrCat("the planner: ", result->status().message()));
      return;
    }
    TakePlan(pose, **result, now);
  }
}

void GoalExecutor::TakePlan(const control::ControlPose& pose,
                            const planning::PlanResult& result,
                            base::MonotonicTime now) {
  const PlanPurpose purpose = asked_->purpose;
  const bool had_blockages = asked_->has_blockages;
  asked_.reset();
  if (result.failure != core::NavigationCause::kNone || result.path.empty()) {
    if (purpose == PlanPurpose::kRoute &&
        result.failure == core::NavigationCause::kPlanTimeout) {
      Ask(PlanPurpose::kFullRoute, pose.pose, Target(), now);
      return;
    }
    // They may have faded meanwhile.
    if (had_blockages) {
      failure_ = result;
      Ask(PlanPurpose::kUnblocked, pose.pose, Target(), now);
      return;
    }
    TakeNoPlan(pose, result, now);
    return;
  }
  if (purpose == PlanPurpose::kUnblocked) {
    BeginTrouble(
        failure_.failure == core::NavigationCause::kStartBlocked
            ? Trouble::kEnclosed
            : Trouble::kNoWay,
        core::NavigationCause::kBlocked,
        absl::StrCat("what stands in the way leaves no other: ", failure_.why),
        now);
    return;
  }
  TakePath(result, had_blockages, is_first_path_ ? "a way" : "another way");
  if (!is_first_path_) ++status_->replans;
  is_first_path_ = false;
  wants_better_ = purpose == PlanPurpose::kRoute;
  asked_next_leg_ = false;
  next_leg_.reset();
  phase_ = GoalPhase::kDriving;
}

void GoalExecutor::TakeNoPlan(const control::ControlPose& pose,
                              const planning::PlanResult& result,
                              base::MonotonicTime now) {
  const std::string why =
      absl::StrCat(result.why.empty() ? "no way was found" : result.why,
                   ", from ", Place(pose.pose), " to ", Place(Target()));
  switch (result.failure) {
    case core::NavigationCause::kStartBlocked:
      BeginTrouble(Trouble::kEnclosed, core::NavigationCause::kStartBlocked,
                   why, now);
      return;
    case core::NavigationCause::kPlanTimeout:
      BeginTrouble(Trouble::kNoWay, core::NavigationCause::kPlanTimeout, why,
                   now);
      return;
    case core::NavigationCause::kNone:
      End(GoalState::kFailed, core::NavigationCause::kInternal,
          "the planner found an empty path");
      return;
    case core::NavigationCause::kNoPath:
      if (is_first_path_) break;
      // Its way led here: a little off, or turned, one leads on.
      BeginTrouble(Trouble::kNoWay, core::NavigationCause::kNoPath, why, now);
      return;
    default:
      break;
  }
  End(GoalState::kFailed, result.failure, why);
}

void GoalExecutor::TakePath(const planning::PlanResult& result,
                            bool had_blockages, const char* what) {
  path_ = result.path;
  beside_goal_m_ = result.moved_goal_m;
  goal_is_taken_ = IsLastLeg() && had_blockages &&
                   beside_goal_m_ > options_.control.goal_tolerance_m;
  way_is_free_ = false;
  if (!result.tree_edges.empty()) tree_edges_ = result.tree_edges;
  controller_->SetPath(path_);
  status_->to_go_m = result.length_m;
  control_ = {};
  control_.to_go_m = result.length_m;
  waiting_since_.reset();
  arrived_since_.reset();
  progress_.Restart();
  std::string text = absl::StrFormat("%s of %.1f m to %s, found in %.1f ms",
                                     what, result.length_m, Place(path_.back()),
                                     1e3 * result.total_s);
  if (result.moved_goal_m > 0) {
    absl::StrAppendFormat(&text,
                          "; %.2f m beside the goal, where there is "
                          "room",
                          result.moved_goal_m);
  }
  events_->Add("plan", std::move(text));
}

void GoalExecutor::StepBackground(const control::ControlPose& pose,
                                  base::MonotonicTime now) {
  if (!asked_.has_value()) {
    if (wants_better_) {
      wants_better_ = false;
      Ask(PlanPurpose::kBetter, pose.pose, Target(), now);
    } else if (!IsLastLeg() && !asked_next_leg_) {
      asked_next_leg_ = true;
      Ask(PlanPurpose::kNextLeg, path_.back(),
          goal_.poses[status_->next_pose + 1], now);
    }
    return;
  }
  std::optional<absl::StatusOr<planning::PlanResult>> result = planner_->Take();
  if (!result.has_value()) return;
  const PlanPurpose purpose = asked_->purpose;
  const bool had_blockages = asked_->has_blockages;
  asked_.reset();
  if (!result->ok() || (*result)->failure != core::NavigationCause::kNone ||
      (*result)->path.empty()) {
    return;
  }
  if (purpose == PlanPurpose::kNextLeg) {
    next_leg_ = **std::move(result);
    return;
  }
  const double from_m = Distance_m((*result)->path.front(), pose.pose);
  if (from_m < kBetterPathStart_m &&
      from_m + (*result)->length_m <
          (1 - options_.limits.better_share) * control_.to_go_m) {
    TakePath(**result, had_blockages, "a shorter way");
  }
}

// ---- driving ----

core::VelocityCommand GoalExecutor::StepDriving(
    const control::ControlPose& pose, base::MonotonicTime now) {
  if (goal_is_taken_ && way_is_free_) {
    if (asked_.has_value()) planner_->Cancel();
    asked_.reset();
    phase_ = GoalPhase::kToPlan;
    return controller_->Guard(pose, {});
  }
  StepBackground(pose, now);
  control_ = controller_->Step(pose);
  status_->to_go_m = control_.to_go_m;
  if (control_.state != control::ControlState::kWaiting) waiting_since_.reset();
  if (control_.state != control::ControlState::kArrived) arrived_since_.reset();
  if (!IsLastLeg() && PassesPose(pose)) {
    NextLeg(pose.pose);
    return control_.command;
  }
  switch (control_.state) {
    case control::ControlState::kIdle:
      phase_ = GoalPhase::kToPlan;
      return control_.command;
    case control::ControlState::kArrived:
      Arrive(pose, now);
      return control_.command;
    case control::ControlState::kBlocked:
      MeetObstacle(pose, control_, "something stands in the way", now);
      return control_.command;
    case control::ControlState::kWaiting:
      if (!waiting_since_.has_value()) {
        waiting_since_ = now;
        events_->Add("blocked", "waits for something that moves");
      }
      progress_.Restart();
      if (base::SecondsBetween(*waiting_since_, now) >
          options_.limits.wait_for_moving_s) {
        MeetObstacle(pose, control_, "what moved does not go away", now);
      }
      return control_.command;
    case control::ControlState::kDriving:
      break;
  }
  const bool gets_on =
      progress_.Observe(now, status_->next_pose, control_.to_go_m,
                        pose.pose.map_from_base.yaw_rad);
  if (progress_.TakeRefill()) {
    ladder_.Refill();
    replans_ = 0;
  }
  if (!gets_on) {
    BeginTrouble(Trouble::kStuck,
                 control_.is_stopped_by_guard
                     ? core::NavigationCause::kCollisionStop
                     : core::NavigationCause::kNoProgress,
                 absl::StrFormat("%.1f m to go, and no nearer for %.0f s",
                                 control_.to_go_m, options_.limits.progress_s),
                 now);
  }
  return control_.command;
}

bool GoalExecutor::PassesPose(const control::ControlPose& pose) const {
  if (control_.state == control::ControlState::kArrived) return true;
  return Distance_m(pose.pose, path_.back()) <=
             options_.limits.waypoint_tolerance_m &&
         std::abs(pose.pose.place.height_m - path_.back().place.height_m) <
             localization::kFloorHeight_m;
}

void GoalExecutor::NextLeg(const core::LevelPose& robot) {
  ++status_->next_pose;
  events_->Add("goal", absl::StrFormat("goal %d: pose %d of %d", status_->id,
                                       status_->next_pose, goal_.poses.size()));
  if (asked_.has_value()) planner_->Cancel();
  asked_.reset();
  asked_next_leg_ = false;
  wants_better_ = false;
  replans_ = 0;
  ladder_.Refill();
  if (!next_leg_.has_value()) {
    is_first_path_ = true;
    phase_ = GoalPhase::kToPlan;
    return;
  }
  // It has not quite come to the pose; the way on begins there.
  planning::PlanResult way = *std::exchange(next_leg_, std::nullopt);
  std::vector<core::LevelPose> rest = RestOf(path_, robot);
  if (rest.size() > 1) {
    way.length_m += Distance_m(rest.front(), rest.back());
    rest.insert(rest.end(), way.path.begin() + 1, way.path.end());
    way.path = std::move(rest);
  }
  TakePath(way, !blockages_.empty(), "the way on");
}

void GoalExecutor::Arrive(const control::ControlPose& pose,
                          base::MonotonicTime now) {
  const core::LevelPose& target = path_.back();
  const double off_m = Distance_m(pose.pose, target);
  const double off_rad = std::abs(geometry::NormalizedAngle_rad(
      pose.pose.map_from_base.yaw_rad - target.map_from_base.yaw_rad));
  const control::LocalControllerOptions& control = options_.control;
  const bool is_there =
      off_m <= control.goal_tolerance_m + kArrivalSlack_m &&
      off_rad <= control.goal_tolerance_rad + kArrivalSlack_rad;
  const bool stands = std::abs(pose.forward_mps) < kArrivedSpeed_mps &&
                      std::abs(pose.yaw_rate_radps) < kArrivedYawRate_radps;
  if (!arrived_since_.has_value()) arrived_since_ = now;
  if (is_there && stands) {
    status_->to_go_m = 0;
    if (goal_is_taken_ &&
        base::SecondsBetween(*arrived_since_, now) < kGoalWait_s) {
      return;
    }
    ++status_->next_pose;
    std::string where =
        absl::StrFormat("%.2f m and %.0f degrees off, after %.1f m", off_m,
                        InDegrees(off_rad), status_->driven_m);
    if (beside_goal_m_ > 0) {
      absl::StrAppendFormat(
          &where, ", at a place %.2f m beside the goal, %s", beside_goal_m_,
          goal_is_taken_ ? "where something stands" : "which has no room");
    }
    End(GoalState::kSucceeded, core::NavigationCause::kNone, where);
    return;
  }
  if (base::SecondsBetween(*arrived_since_, now) > kArrivalDispute_s) {
    arrived_since_.reset();
    if (++replans_ > options_.limits.max_replans) {
      BeginTrouble(Trouble::kStuck, core::NavigationCause::kNoProgress,
                   "it does not come to stand at the goal", now);
      return;
    }
    phase_ = GoalPhase::kToPlan;
  }
}

void GoalExecutor::MeetObstacle(const control::ControlPose& pose,
                                const control::ControlResult& result,
                                const std::string& what,
                                base::MonotonicTime now) {
  const std::optional<core::LevelPlace> ground =
      map_->GroundNear(result.obstacle_in_map, pose.pose.place.height_m);
  const double margin_m = options_.limits.blockage_margin_m;
  for (const planning::Blockage& disc :
       DiscsOf(controller_->Costmap(), result.obstacle_in_map,
               pose.pose.map_from_base.translation, margin_m,
               result.obstacle_radius_m + margin_m,
               ground.has_value() ? ground->level : pose.pose.place.level)) {
    blockages_.Add(disc, now);
  }
  events_->Add("blocked", absl::StrFormat("%s at (%.2f, %.2f)", what,
                                          result.obstacle_in_map.x,
                                          result.obstacle_in_map.y));
  waiting_since_.reset();
  if (asked_.has_value()) planner_->Cancel();
  asked_.reset();
  if (++replans_ > options_.limits.max_replans) {
    BeginTrouble(Trouble::kNoWay, core::NavigationCause::kBlocked,
                 absl::StrFormat("%d ways around what stands there are blocked",
                                 options_.limits.max_replans),
                 now);
    return;
  }
  phase_ = GoalPhase::kToPlan;
}

// ---- recoveries ----

void GoalExecutor::BeginTrouble(Trouble trouble, core::NavigationCause cause,
                                const std::string& why,
                                base::MonotonicTime now) {
  if (asked_.has_value()) planner_->Cancel();
  asked_.reset();
  trouble_ = trouble;
  trouble_cause_ = cause;
  trouble_why_ = why;
  NextManeuver(now);
}

void GoalExecutor::NextManeuver(base::MonotonicTime now) {
  const std::optional<RecoverySequenceStep> rung = ladder_.Next(trouble_);
  if (!rung.has_value()) {
    const core::NavigationCause cause = trouble_cause_;
    End(GoalState::kFailed, cause,
        absl::StrFormat("%s; %d recoveries did not help", trouble_why_,
                        ladder_.used()));
    return;
  }
  ++status_->recoveries;
  maneuver_.emplace(*rung, options_.limits, now);
  maneuver_since_ = now;
  way_is_free_ = false;
  events_->Add(
      "recovery",
      absl::StrFormat("%s (%s: %s)", RecoveryBehaviorName(rung->kind),
                      core::NavigationCauseName(trouble_cause_), trouble_why_));
  phase_ = GoalPhase::kRecovering;
}

core::VelocityCommand GoalExecutor::StepManeuver(
    const control::ControlPose& pose, base::MonotonicTime now) {
  if (way_is_free_ && maneuver_->kind() == RecoveryBehaviorKind::kWait &&
      base::SecondsBetween(maneuver_since_, now) > kMinWait_s) {
    maneuver_.reset();
    ladder_.GiveBack();
    trouble_cause_ = core::NavigationCause::kNone;
    phase_ = GoalPhase::kToPlan;
    return controller_->Guard(pose, {});
  }
  const RecoveryBehavior::Result result =
      maneuver_->Step(pose, now, *controller_);
  if (result.outcome == RecoveryBehaviorOutcome::kRunning)
    return result.command;
  const RecoveryBehaviorKind kind = maneuver_->kind();
  maneuver_.reset();
  if (kind == RecoveryBehaviorKind::kReroute) BlockAhead(pose, now);
  events_->Add("recovery",
               absl::StrFormat("%s: %s", RecoveryBehaviorName(kind),
                               RecoveryBehaviorOutcomeName(result.outcome)));
  if (result.outcome == RecoveryBehaviorOutcome::kNotPossible) {
    NextManeuver(now);
  } else {
    trouble_cause_ = core::NavigationCause::kNone;
    phase_ = GoalPhase::kToPlan;
  }
  return controller_->Guard(pose, {});
}

void GoalExecutor::BlockAhead(const control::ControlPose& pose,
                              base::MonotonicTime now) {
  blockages_.Add(
      {.center = pose.pose.map_from_base * geometry::Vec2{kRerouteAhead_m, 0},
       .radius_m = kRerouteRadius_m,
       .level = pose.pose.place.level},
      now);
}

}  // namespace treeline::behavior
