// /api/stream: Server-Sent Events.
#include <atomic>

#include "absl/strings/str_cat.h"
#include "nav_agent/service/api_json.h"
#include "nav_agent/service/http_api.h"

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

// Counts a stream for as long as somebody holds it.
class StreamTicket {
 public:
  explicit StreamTicket(std::atomic<int>& streams) : streams_(streams) {}
  ~StreamTicket() { --streams_; }
  StreamTicket(const StreamTicket&) = delete;
  StreamTicket& operator=(const StreamTicket&) = delete;

 private:
  std::atomic<int>& streams_;
};

}  // namespace

http::HttpResponse HttpApi::OpenStream() {
  if (++streams_ > options_.max_streams) {
    --streams_;
    return {.status = 503,
            .content_type = "application/json",
            .body = ErrorJson("resource_exhausted",
                              "too many pages watch already; close one"),
            .headers = {{"Retry-After", "5"}}};
  }
  const auto ticket = std::make_shared<StreamTicket>(streams_);
  return {.content_type = "text/event-stream",
          .stream = [this, ticket](http::HttpBodyWriter& writer) {
            RunStream(writer);
          }};
}

void HttpApi::RunStream(http::HttpBodyWriter& writer) {
  const AgentHub& hub = commands_.hub();
  uint64_t seen = 0;
  uint64_t sent = 0;
  const uint64_t last = hub.last_event();
  uint64_t event = last > kPastEvents ? last - kPastEvents : 0;
  // Browsers that lose the stream come back after this (ms).
  if (!writer.Write("retry: 1000\n\n")) return;
  while (!hub.is_closed()) {
    const auto state = hub.WaitForNewer(seen, absl::Now() + options_.heartbeat);
    std::string text;
    if (state == nullptr) {
      text = ": nothing new\n\n";
    } else {
      seen = state->number;
      const auto texts = TextsOf(*state);
      text = Sent("state", texts->state);
      if (sent++ % kStatesInScene == 0) {
        absl::StrAppend(&text, Sent("scene", texts->scene));
      }
    }
    for (const AgentHub::Event& one : hub.EventsAfter(event, kEventsAtOnce)) {
      absl::StrAppend(&text, Sent("event", EventJson(one)));
      event = one.number;
    }
    if (!writer.Write(text)) return;
  }
}

}  // namespace treeline::agent_service
