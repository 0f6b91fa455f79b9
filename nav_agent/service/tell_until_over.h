// A call that tells of something until it is over.
#ifndef NAV_AGENT_SERVICE_TELL_UNTIL_OVER_H_
#define NAV_AGENT_SERVICE_TELL_UNTIL_OVER_H_

#include <optional>

#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "nav_agent/service/agent_hub.h"
#include "nav_agent/service/message_sink.h"

namespace treeline::agent_service {

// Writes what `feedback_of` makes of each new AgentState, until a message
// is_final. nullopt: nothing, the state is older than what is told of.
// CANCELLED: the caller has gone; UNAVAILABLE: the hub is closed.
template <typename Message, typename FeedbackOf>
absl::Status TellUntilOver(const AgentHub& hub, const FeedbackOf& feedback_of,
                           MessageSink<Message>& sink) {
  // A call that was cancelled is noticed after this at most.
  constexpr absl::Duration kLookUp = absl::Milliseconds(50);
  uint64_t seen = 0;
  for (;;) {
    if (sink.IsGone()) {
      return absl::CancelledError("the call ended before it was over");
    }
    if (hub.is_closed()) {
      return absl::UnavailableError("the agent is stopping");
    }
    const auto state = hub.WaitForNewer(seen, absl::Now() + kLookUp);
    if (state == nullptr) continue;
    seen = state->number;
    const std::optional<Message> feedback = feedback_of(*state);
    if (!feedback.has_value()) continue;
    if (!sink.Write(*feedback)) {
      return absl::CancelledError("the caller has gone");
    }
    if (feedback->is_final()) return absl::OkStatus();
  }
}

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_TELL_UNTIL_OVER_H_
