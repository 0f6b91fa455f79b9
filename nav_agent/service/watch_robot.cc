#include "nav_agent/service/watch_robot.h"

#include <algorithm>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "common/base/status_macros.h"
#include "common/wire/geometry.h"
#include "nav_agent/service/navigation_wire.h"

namespace treeline::agent_service {
namespace {

constexpr absl::Duration kLookUp = absl::Milliseconds(50);
constexpr double kMaxRate_hz = 10;
constexpr double kMinRate_hz = 0.1;
constexpr int kMaxPastEvents = 1000;
constexpr size_t kEventsAtOnce = 100;
// Scenes are large, and need not be as fluent as the robot itself.
constexpr uint64_t kStatesInScene = 2;

absl::Status Check(const v1::StreamStateRequest& request) {
  const double rate_hz = request.rate_hz();
  if (rate_hz != 0 && !(rate_hz >= kMinRate_hz && rate_hz <= kMaxRate_hz)) {
    return wire::FieldError(
        "rate_hz", absl::StrCat("is ", rate_hz, "; it must be 0.1..10"));
  }
  if (request.past_events() < 0 || request.past_events() > kMaxPastEvents) {
    return wire::FieldError(
        "past_events",
        absl::StrCat("is ", request.past_events(), "; it must be 0..1000"));
  }
  return absl::OkStatus();
}

// Events after a number, in messages.
class EventReader {
 public:
  EventReader(const AgentHub& hub, int past_events) : hub_(hub) {
    const uint64_t last = hub.last_event();
    number_ =
        last - std::min<uint64_t>(last, static_cast<uint64_t>(past_events));
    at_once_ = std::max(kEventsAtOnce, static_cast<size_t>(past_events));
  }
  void Append(v1::StreamStateResponse& message) {
    for (const AgentHub::Event& one : hub_.EventsAfter(number_, at_once_)) {
      *message.add_events() = ToProto(one);
      number_ = one.number;
    }
    at_once_ = kEventsAtOnce;
  }

 private:
  const AgentHub& hub_;
  uint64_t number_ = 0;
  size_t at_once_ = 0;
};

}  // namespace

absl::Status WatchRobot(const AgentInfo& info, const AgentHub& hub,
                        const v1::StreamStateRequest& request,
                        MessageSink<v1::StreamStateResponse>& sink) {
  TL_RETURN_IF_ERROR(Check(request));
  const double rate_hz =
      request.rate_hz() == 0 ? kMaxRate_hz : request.rate_hz();
  // States come at kMaxRate_hz: a little less than the interval, so that none
  // of them is passed over for being a millisecond early.
  const absl::Duration interval =
      absl::Seconds(1 / rate_hz) - absl::Milliseconds(50);
  absl::Time next = absl::InfinitePast();
  uint64_t seen = 0;
  uint64_t sent = 0;
  EventReader events(hub, request.past_events());
  while (!sink.IsGone()) {
    if (hub.is_closed()) {
      return absl::UnavailableError("the agent is stopping");
    }
    const auto state = hub.WaitForNewer(seen, absl::Now() + kLookUp);
    if (state == nullptr) continue;
    seen = state->number;
    const absl::Time now = absl::Now();
    if (now < next) continue;
    next = now + interval;
    v1::StreamStateResponse message;
    *message.mutable_state() = StateToProto(info, *state);
    events.Append(message);
    if (request.with_scene() && sent++ % kStatesInScene == 0) {
      *message.mutable_scene() = SceneToProto(*state);
    }
    if (!sink.Write(message)) break;
  }
  return absl::CancelledError("the caller has gone");
}

}  // namespace treeline::agent_service
