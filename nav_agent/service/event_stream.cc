#include "nav_agent/service/event_stream.h"

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "nav_agent/service/api_json.h"
#include "nav_agent/service/navigation_wire.h"

namespace treeline::agent_service {
namespace {

// Every so many states, the heavy parts too: 10 Hz and 5 Hz.
constexpr uint64_t kStatesInScene = 2;
// What happened before a browser came, and at a time.
constexpr uint64_t kPastEvents = 50;
constexpr size_t kEventsAtOnce = 100;

std::string Sent(absl::string_view event, absl::string_view data) {
  // JSON has no line breaks.
  return absl::StrCat("event: ", event, "\ndata: ", data, "\n\n");
}

}  // namespace

void RunEventStream(const AgentHub& hub, const StateTextsOf& texts_of,
                    absl::Duration heartbeat, http::HttpBodyWriter& writer) {
  uint64_t seen = 0;
  uint64_t sent = 0;
  const uint64_t last = hub.last_event();
  uint64_t event = last > kPastEvents ? last - kPastEvents : 0;
  // Browsers that lose the stream come back after this (ms).
  if (!writer.Write("retry: 1000\n\n")) return;
  while (!hub.is_closed()) {
    const auto state = hub.WaitForNewer(seen, absl::Now() + heartbeat);
    std::string text;
    if (state == nullptr) {
      text = ": nothing new\n\n";
    } else {
      seen = state->number;
      const auto texts = texts_of(*state);
      text = Sent("state", texts->state);
      if (sent++ % kStatesInScene == 0) {
        absl::StrAppend(&text, Sent("scene", texts->scene));
      }
    }
    for (const AgentHub::Event& one : hub.EventsAfter(event, kEventsAtOnce)) {
      absl::StrAppend(&text, Sent("event", EventJson(ToProto(one))));
      event = one.number;
    }
    if (!writer.Write(text)) return;
  }
}

}  // namespace treeline::agent_service
