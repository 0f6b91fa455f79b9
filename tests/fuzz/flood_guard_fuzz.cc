// What clients send to a guarded port as arbitrary bytes: no crash; the same
// counts and the same end however the bytes arrive; no more frames than their
// bytes have room for.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <utility>

#include "absl/strings/string_view.h"
#include "common/base/clock.h"
#include "common/flood_guard/flood_guard.h"
#include "common/flood_guard/frame_counter.h"
#include "common/flood_guard/watched_connection.h"

namespace {

using treeline::flood_guard::FloodGuard;
using treeline::flood_guard::FrameCounter;
using treeline::flood_guard::FrameCounts;
using treeline::flood_guard::WatchedConnection;

constexpr absl::string_view kPreface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
constexpr int64_t kFrameHead = 9;

void Check(bool holds) {
  if (!holds) std::abort();
}

std::pair<FrameCounts, bool> Count(absl::string_view bytes, size_t step) {
  FrameCounter counter;
  FrameCounts counts;
  bool goes_on = counter.Count(kPreface, counts);
  while (!bytes.empty()) {
    const absl::string_view piece = bytes.substr(0, step);
    bytes.remove_prefix(piece.size());
    goes_on = counter.Count(piece, counts);
  }
  return {counts, goes_on};
}

// The first bytes decide between HTTP/2 and TLS.
void Watch(absl::string_view bytes, size_t step) {
  const treeline::base::SteadyClock clock;
  const auto guard =
      std::make_shared<FloodGuard>(treeline::flood_guard::FloodLimits(), clock);
  const auto watched = WatchedConnection::Open(guard, "a", "a:1");
  Check(watched != nullptr);
  while (!bytes.empty()) {
    const absl::string_view piece = bytes.substr(0, step);
    bytes.remove_prefix(piece.size());
    if (watched->Receive(piece) == WatchedConnection::Verdict::kTlsBegins) {
      Check(watched->client_random().size() == 32);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const size_t step = 1 + data[size - 1] % 13;
  const auto [counts, goes_on] = Count(bytes, size);
  Check(Count(bytes, step) == std::make_pair(counts, goes_on));
  const auto whole = static_cast<int64_t>(size) / kFrameHead;
  Check(counts.frames <= whole);
  // What a head announces counts when it is announced.
  Check(counts.calls <= whole * (1 + (1 << 24) / FrameCounter::kBytesOfACall));
  Watch(bytes, step);
  return 0;
}
