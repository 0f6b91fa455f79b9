#include "nav_agent/bridge/navigate_action/navigate_action.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/ros2/conversions/geometry_values.h"
#include "nav_agent/bridge/agent_report/agent_report.h"

namespace treeline::navigate_action {
namespace {

using core::NavigationCause;
using messages::CancelGoalResponse;
using messages::GoalStatus;

// Nav2 estimates a time only from so much speed and way on (bt_navigator).
constexpr double kMinSpeed_mps = 0.01;
constexpr double kMinWay_m = 0.1;
constexpr double kMostSeconds = 1e6;

// nav2_msgs/action/FollowPath and ComputePathToPose of Iron and Jazzy.
enum Nav2Error : uint16_t {
  kControlUnknown = 100,
  kTransformError = 102,
  kFailedToMakeProgress = 105,
  kNoValidControl = 106,
  kGoalOutsideMap = 204,
  kStartOccupied = 205,
  kGoalOccupied = 206,
  kPlanTimeout = 207,
  kNoValidPath = 208
};

messages::Duration DurationOf(double seconds) {
  const double bounded = std::clamp(seconds, 0., kMostSeconds);
  const auto whole = static_cast<int32_t>(bounded);
  return {.sec = whole,
          .nanosec = static_cast<uint32_t>((bounded - whole) * 1e9)};
}

}  // namespace

uint16_t ErrorCodeOf(NavigationCause cause) {
  switch (cause) {
    case NavigationCause::kNone:
    // As Nav2: who is pushed aside has made no error.
    case NavigationCause::kPreempted:
    case NavigationCause::kCancelled:
      return 0;
    case NavigationCause::kStartBlocked:
      return kStartOccupied;
    case NavigationCause::kGoalBlocked:
      return kGoalOccupied;
    case NavigationCause::kGoalOutside:
      return kGoalOutsideMap;
    case NavigationCause::kPlanTimeout:
      return kPlanTimeout;
    case NavigationCause::kNoPath:
    case NavigationCause::kZone:
      return kNoValidPath;
    case NavigationCause::kBlocked:
    case NavigationCause::kNoProgress:
    case NavigationCause::kRecoveryFailed:
      return kFailedToMakeProgress;
    case NavigationCause::kCollisionStop:
      return kNoValidControl;
    case NavigationCause::kEstimateLost:
    case NavigationCause::kNeedHelp:
      return kTransformError;
    default:
      return kControlUnknown;
  }
}

NavigateAction::Goal* NavigateAction::Current() {
  return goals_.empty() || goals_.back().HasEnded() ? nullptr : &goals_.back();
}

const NavigateAction::Goal* NavigateAction::Find(
    const messages::Uuid& id) const {
  const auto found = std::ranges::find_if(
      goals_, [&](const Goal& goal) { return goal.info.goal_id == id; });
  return found == goals_.end() ? nullptr : &*found;
}

NavigateAction::Answer NavigateAction::Take(
    const messages::NavigateToPoseSendGoalRequest& request,
    const Moment& moment) {
  if (Find(request.goal_id) != nullptr) {
    return {.response = {},
            .why = absl::InvalidArgumentError("a goal with this id is known")};
  }
  if (!request.goal.behavior_tree.empty()) {
    return {.response = {},
            .why = absl::InvalidArgumentError(absl::StrCat(
                "it asks for the behavior tree ", request.goal.behavior_tree,
                "; none are run here: leave it empty"))};
  }
  const absl::StatusOr<uint64_t> number = agent_.set_goal(request.goal.pose);
  if (!number.ok()) return {.response = {}, .why = number.status()};
  if (Goal* before = Current(); before != nullptr) {
    End(*before, GoalStatus::kAborted, moment.now,
        {.error_code = 0, .error_msg = "another goal took its place"});
  }
  Forget(moment.now);
  goals_.push_back({.info = {.goal_id = request.goal_id, .stamp = moment.stamp},
                    .number = *number,
                    .began = moment.now});
  current_id_ = request.goal_id;
  is_changed_ = true;
  return {.response = {.accepted = true, .stamp = moment.stamp}, .why = {}};
}

bool NavigateAction::CancelOne(Goal& goal) {
  // One that has ended meanwhile is told by the next state.
  if (goal.status != GoalStatus::kCanceling && !agent_.cancel(goal.number).ok())
    return false;
  goal.status = GoalStatus::kCanceling;
  is_changed_ = true;
  return true;
}

CancelGoalResponse NavigateAction::Cancel(
    const messages::CancelGoalRequest& request) {
  const messages::GoalInfo& wanted = request.goal_info;
  const bool is_named = wanted.goal_id != messages::Uuid();
  const bool is_stamped = wanted.stamp != messages::Time();
  CancelGoalResponse response;
  if (is_named && !is_stamped) {
    const Goal* goal = Find(wanted.goal_id);
    if (goal == nullptr) {
      response.return_code = CancelGoalResponse::kUnknownGoalId;
      return response;
    }
    if (goal->HasEnded()) {
      response.return_code = CancelGoalResponse::kGoalTerminated;
      return response;
    }
  }
  Goal* current = Current();
  if (current == nullptr) return response;
  const bool is_meant =
      (!is_named && !is_stamped) || wanted.goal_id == current->info.goal_id ||
      (is_stamped && messages::Nanoseconds(current->info.stamp) <=
                         messages::Nanoseconds(wanted.stamp));
  if (!is_meant) return response;
  if (CancelOne(*current)) {
    response.goals_canceling.push_back(current->info);
  } else {
    response.return_code = CancelGoalResponse::kRejected;
  }
  return response;
}

std::optional<messages::NavigateToPoseGetResultResponse>
NavigateAction::ResultOf(const messages::Uuid& goal_id) const {
  const Goal* goal = Find(goal_id);
  if (goal == nullptr) return messages::NavigateToPoseGetResultResponse{};
  if (!goal->HasEnded()) return std::nullopt;
  return messages::NavigateToPoseGetResultResponse{.status = goal->status,
                                                   .result = goal->result};
}

void NavigateAction::End(Goal& goal, int8_t status, base::MonotonicTime now,
                         messages::NavigateToPoseResult result) {
  goal.status = status;
  goal.ended = now;
  goal.result = std::move(result);
  is_changed_ = true;
}

void NavigateAction::Judge(Goal& goal, const behavior::GoalStatus& driven,
                           base::MonotonicTime now) {
  // A state from before the goal was set.
  if (driven.id < goal.number) return;
  if (driven.id > goal.number) {
    return End(goal, GoalStatus::kAborted, now,
               {.error_code = 0, .error_msg = "another goal took its place"});
  }
  switch (driven.state) {
    case behavior::GoalState::kAccepted:
    case behavior::GoalState::kActive:
      return;
    case behavior::GoalState::kSucceeded:
      return End(goal, GoalStatus::kSucceeded, now, {});
    case behavior::GoalState::kCancelled:
      // Without a request of a client, CANCELED is no end that it can have.
      if (goal.status == GoalStatus::kCanceling) {
        return End(goal, GoalStatus::kCanceled, now, {});
      }
      [[fallthrough]];
    case behavior::GoalState::kFailed:
      return End(goal, GoalStatus::kAborted, now,
                 {.error_code = ErrorCodeOf(driven.cause),
                  .error_msg = driven.why.empty()
                                   ? core::NavigationCauseAdvice(driven.cause)
                                   : driven.why});
  }
}

std::optional<messages::NavigateToPoseFeedback> NavigateAction::Follow(
    const agent_service::AgentState& state, const Moment& moment,
    const std::string& map_frame) {
  const behavior::NavigatorSnapshot& robot = state.snapshot;
  Goal* goal = Current();
  if (goal != nullptr && robot.goal.has_value()) {
    Judge(*goal, *robot.goal, moment.now);
    goal = Current();
  }
  Forget(moment.now);
  if (goal == nullptr || !robot.goal.has_value() ||
      robot.goal->id != goal->number) {
    return std::nullopt;
  }
  messages::NavigateToPoseFeedback feedback;
  feedback.current_pose.header = {.stamp = moment.stamp, .frame_id = map_frame};
  if (robot.pose.has_value()) {
    feedback.current_pose.pose =
        conversions::PoseOf(agent_report::MapFromBase(*robot.pose));
  }
  feedback.navigation_time =
      DurationOf(base::SecondsBetween(goal->began, moment.now));
  const double to_go_m = robot.goal->to_go_m;
  const double speed_mps = std::abs(robot.command.forward_mps);
  if (speed_mps > kMinSpeed_mps && to_go_m > kMinWay_m) {
    feedback.estimated_time_remaining = DurationOf(to_go_m / speed_mps);
  }
  feedback.number_of_recoveries = static_cast<int16_t>(std::min<int>(
      robot.goal->recoveries, std::numeric_limits<int16_t>::max()));
  feedback.distance_remaining = static_cast<float>(to_go_m);
  return feedback;
}

void NavigateAction::Abort(const std::string& why, const Moment& moment) {
  if (Goal* goal = Current(); goal != nullptr) {
    End(*goal, GoalStatus::kAborted, moment.now,
        {.error_code = kControlUnknown, .error_msg = why});
  }
}

messages::GoalStatusArray NavigateAction::Statuses() const {
  messages::GoalStatusArray array;
  for (const Goal& goal : goals_) {
    array.status_list.push_back(
        {.goal_info = goal.info, .status = goal.status});
  }
  return array;
}

void NavigateAction::Forget(base::MonotonicTime now) {
  while (!goals_.empty() && goals_.front().HasEnded() &&
         (goals_.size() > kMaxEnded ||
          base::SecondsBetween(goals_.front().ended, now) > kRememberFor_s)) {
    goals_.pop_front();
    is_changed_ = true;
  }
}

}  // namespace treeline::navigate_action
