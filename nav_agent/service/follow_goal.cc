#include "nav_agent/service/follow_goal.h"

#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/service/navigation_wire.h"

namespace treeline::agent_service {
namespace {

// A call that was cancelled is noticed after this at most.
constexpr absl::Duration kLookUp = absl::Milliseconds(50);

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

// Tells of the goal until it is over.
absl::Status TellUntilOver(const AgentHub& hub, uint64_t goal_id,
                           MessageSink<v1::NavigateResponse>& sink) {
  uint64_t seen = 0;
  for (;;) {
    if (sink.IsGone()) {
      return absl::CancelledError("the call ended before the goal did");
    }
    if (hub.is_closed()) {
      return absl::UnavailableError("the agent is stopping");
    }
    const auto state = hub.WaitForNewer(seen, absl::Now() + kLookUp);
    if (state == nullptr) continue;
    seen = state->number;
    const std::optional<v1::NavigateResponse> feedback =
        FeedbackOf(*state, goal_id);
    if (!feedback.has_value()) continue;
    if (!sink.Write(*feedback)) {
      return absl::CancelledError("the caller has gone");
    }
    if (feedback->is_final()) return absl::OkStatus();
  }
}

}  // namespace

absl::Status FollowGoal(AgentCommands& commands,
                        const v1::NavigateRequest& request,
                        MessageSink<v1::NavigateResponse>& sink) {
  TL_ASSIGN_OR_RETURN(const uint64_t goal_id,
                      commands.SetGoal(FromProto(request.poses())));
  const absl::Status told = TellUntilOver(commands.hub(), goal_id, sink);
  if (absl::IsCancelled(told) && !request.keep_when_call_ends()) {
    // NOT_FOUND where it is over by now, or another took its place.
    commands.Cancel(goal_id).IgnoreError();
  }
  return told;
}

}  // namespace treeline::agent_service
