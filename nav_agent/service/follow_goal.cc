#include "nav_agent/service/follow_goal.h"

#include <optional>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/service/navigation_wire.h"
#include "nav_agent/service/tell_until_over.h"

namespace treeline::agent_service {
namespace {

bool IsOver(behavior::GoalState state) {
  return state == behavior::GoalState::kSucceeded ||
         state == behavior::GoalState::kFailed ||
         state == behavior::GoalState::kCancelled;
}

// nullopt: the state is older than the goal.
std::optional<v1::NavigateResponse> FeedbackOf(const AgentState& state,
                                               uint64_t goal_id) {
  const std::optional<behavior::GoalStatus>& goal = state.snapshot.goal;
  if (!goal.has_value() || goal->id < goal_id) return std::nullopt;
  v1::NavigateResponse message = FeedbackToProto(state);
  if (goal->id == goal_id) {
    message.set_is_final(IsOver(goal->state));
    return message;
  }
  v1::GoalStatus& status = *message.mutable_goal();
  status.Clear();
  status.set_id(goal_id);
  status.set_state(v1::GOAL_STATE_FAILED);
  status.set_cause(v1::NAVIGATION_CAUSE_PREEMPTED);
  status.set_why(absl::StrCat("goal ", goal->id, " took its place"));
  message.set_is_final(true);
  return message;
}

}  // namespace

absl::Status FollowGoal(AgentCommands& commands,
                        const v1::NavigateRequest& request,
                        MessageSink<v1::NavigateResponse>& sink) {
  TL_ASSIGN_OR_RETURN(const uint64_t goal_id,
                      commands.SetGoal(FromProto(request.poses())));
  const absl::Status told = TellUntilOver<v1::NavigateResponse>(
      commands.hub(),
      [goal_id](const AgentState& state) { return FeedbackOf(state, goal_id); },
      sink);
  if (absl::IsCancelled(told) && !request.keep_when_call_ends()) {
    // NOT_FOUND where it is over by now, or another took its place.
    commands.Cancel(goal_id).IgnoreError();
  }
  return told;
}

}  // namespace treeline::agent_service
