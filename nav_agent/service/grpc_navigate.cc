// Goals over gRPC.
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "common/wire/status.h"
#include "nav_agent/service/grpc_services.h"
#include "nav_agent/service/navigation_wire.h"
#include "nav_agent/service/stream_slot.h"

namespace treeline::agent_service {
namespace {

// A call that was cancelled is noticed after this at most.
constexpr absl::Duration kLookUp = absl::Milliseconds(50);

bool IsOver(behavior::GoalState state) {
  return state == behavior::GoalState::kSucceeded ||
         state == behavior::GoalState::kFailed ||
         state == behavior::GoalState::kCancelled;
}

// What a goal's caller is told of it.
struct Feedback {
  v1::NavigateResponse message;
  // Another goal is driven to.
  bool is_preempted = false;
};

// nullopt: the state is older than the goal.
std::optional<Feedback> FeedbackOf(const AgentState& state, uint64_t goal_id) {
  const std::optional<behavior::GoalStatus>& goal = state.snapshot.goal;
  if (!goal.has_value() || goal->id < goal_id) return std::nullopt;
  Feedback feedback{.message = FeedbackToProto(state)};
  if (goal->id == goal_id) {
    feedback.message.set_is_final(IsOver(goal->state));
    return feedback;
  }
  feedback.is_preempted = true;
  v1::GoalStatus& status = *feedback.message.mutable_goal();
  status.Clear();
  status.set_id(goal_id);
  status.set_state(v1::GOAL_STATE_FAILED);
  status.set_cause(v1::NAVIGATION_CAUSE_PREEMPTED);
  status.set_why(absl::StrCat("goal ", goal->id, " took its place"));
  feedback.message.set_is_final(true);
  return feedback;
}

// Sends feedback until the goal is over. False: the call ended before.
absl::Status Follow(const AgentHub& hub, uint64_t goal_id,
                    const grpc::ServerContext& context,
                    grpc::ServerWriter<v1::NavigateResponse>& writer) {
  uint64_t seen = 0;
  for (;;) {
    if (context.IsCancelled()) {
      return absl::CancelledError("the call ended before the goal did");
    }
    if (hub.is_closed()) {
      return absl::UnavailableError("the agent is stopping");
    }
    const auto state = hub.WaitForNewer(seen, absl::Now() + kLookUp);
    if (state == nullptr) continue;
    seen = state->number;
    const std::optional<Feedback> feedback = FeedbackOf(*state, goal_id);
    if (!feedback.has_value()) continue;
    if (!writer.Write(feedback->message)) {
      return absl::CancelledError("the caller has gone");
    }
    if (feedback->message.is_final()) return absl::OkStatus();
  }
}

}  // namespace

grpc::Status NavigationGrpcService::Navigate(
    grpc::ServerContext* context, const v1::NavigateRequest* request,
    grpc::ServerWriter<v1::NavigateResponse>* writer) {
  const StreamSlot slot(streams_, max_streams_);
  if (!slot.is_taken()) {
    return wire::ToGrpc(
        absl::ResourceExhaustedError("too many streams are open"));
  }
  const absl::StatusOr<uint64_t> goal_id =
      commands_.SetGoal(FromProto(request->poses()));
  if (!goal_id.ok()) return wire::ToGrpc(goal_id.status());
  const absl::Status followed =
      Follow(commands_.hub(), *goal_id, *context, *writer);
  if (absl::IsCancelled(followed) && !request->keep_when_call_ends()) {
    // NOT_FOUND where it is over by now, or another took its place.
    commands_.Cancel(*goal_id).IgnoreError();
  }
  return wire::ToGrpc(followed);
}

grpc::Status NavigationGrpcService::Cancel(grpc::ServerContext* /*context*/,
                                           const v1::CancelRequest* request,
                                           v1::CancelResponse* /*response*/) {
  return wire::ToGrpc(commands_.Cancel(request->goal_id()));
}

grpc::Status NavigationGrpcService::Pause(grpc::ServerContext* /*context*/,
                                          const v1::PauseRequest* /*request*/,
                                          v1::PauseResponse* /*response*/) {
  return wire::ToGrpc(commands_.Pause());
}

grpc::Status NavigationGrpcService::Resume(grpc::ServerContext* /*context*/,
                                           const v1::ResumeRequest* /*request*/,
                                           v1::ResumeResponse* /*response*/) {
  return wire::ToGrpc(commands_.Resume());
}

}  // namespace treeline::agent_service
