// Replies to clients that cannot hear them yet: their request has come before
// their reader was found. For the implementations of Service.
#ifndef NAV_AGENT_BRIDGE_DDS_KEPT_REPLIES_H_
#define NAV_AGENT_BRIDGE_DDS_KEPT_REPLIES_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "nav_agent/bridge/dds/service.h"

namespace treeline::dds {

enum class Hearing {
  kHears,
  kNotYet,
  // The client has ended.
  kGone
};

class KeptReplies {
 public:
  // Of more than 64 the oldest are dropped, and each after ten seconds.
  void Keep(const RequestId& id, std::span<const uint8_t> bytes) {
    if (kept_.size() >= kMaxKept) kept_.pop_front();
    kept_.push_back({.id = id,
                     .bytes = {bytes.begin(), bytes.end()},
                     .until = absl::Now() + kKeptFor});
  }
  // hearing(id): how it is now; write(id, bytes): sends one.
  template <typename HearingOf, typename Write>
  void Send(const HearingOf& hearing, const Write& write) {
    std::deque<Kept> kept = std::exchange(kept_, {});
    const absl::Time now = absl::Now();
    for (Kept& reply : kept) {
      const Hearing heard = hearing(reply.id);
      if (heard == Hearing::kHears) {
        write(reply.id, reply.bytes);
      } else if (heard == Hearing::kNotYet && now < reply.until) {
        kept_.push_back(std::move(reply));
      }
    }
  }

 private:
  static constexpr size_t kMaxKept = 64;
  static constexpr absl::Duration kKeptFor = absl::Seconds(10);
  struct Kept {
    RequestId id;
    std::vector<uint8_t> bytes;
    absl::Time until;
  };

  std::deque<Kept> kept_;
};

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_KEPT_REPLIES_H_
