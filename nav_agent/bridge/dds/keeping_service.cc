#include "nav_agent/bridge/dds/keeping_service.h"

#include "absl/time/clock.h"

namespace treeline::dds {
namespace {

constexpr size_t kMaxKept = 64;
constexpr absl::Duration kKeptFor = absl::Seconds(10);

}  // namespace

std::vector<Request> KeepingService::Take() {
  std::deque<Kept> kept = std::exchange(kept_, {});
  const absl::Time now = absl::Now();
  for (Kept& reply : kept) {
    const Hearing heard = HearingOf(reply.id);
    if (heard == Hearing::kHears) {
      // Who hears a reply asks again if it is lost.
      Write(reply.id, reply.bytes).IgnoreError();
    } else if (heard == Hearing::kNotYet && now < reply.until) {
      kept_.push_back(std::move(reply));
    }
  }
  return TakeRequests();
}

absl::Status KeepingService::Reply(const RequestId& id,
                                   std::span<const uint8_t> bytes) {
  if (bytes.size() < kEncodingBytes) {
    return absl::InvalidArgumentError("a reply without its encoding");
  }
  switch (HearingOf(id)) {
    case Hearing::kHears:
      return Write(id, bytes);
    case Hearing::kGone:
      return absl::OkStatus();
    case Hearing::kNotYet:
      break;
  }
  if (kept_.size() >= kMaxKept) kept_.pop_front();
  kept_.push_back({.id = id,
                   .bytes = {bytes.begin(), bytes.end()},
                   .until = absl::Now() + kKeptFor});
  return absl::OkStatus();
}

}  // namespace treeline::dds
