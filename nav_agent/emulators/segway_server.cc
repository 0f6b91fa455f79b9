#include "nav_agent/emulators/segway_server.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <vector>

#include "common/base/status_macros.h"

namespace treeline {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLongestRead(10);

}  // namespace

absl::Status ServeSegway(SegwayEmulator& emulator, ByteStream& stream,
                         const Clock& clock, const std::stop_token& stop) {
  std::array<uint8_t, 1024> buffer;
  while (!stop.stop_requested()) {
    const MonotonicTime now = clock.Now();
    const std::vector<uint8_t> bytes = emulator.Advance(now);
    if (!bytes.empty()) {
      // A full buffer means that nobody listens.
      stream.Write(bytes, milliseconds(0)).IgnoreError();
    }
    const milliseconds wait =
        std::clamp(std::chrono::ceil<milliseconds>(emulator.NextCycle() - now),
                   milliseconds(1), kLongestRead);
    TL_ASSIGN_OR_RETURN(const size_t count, stream.Read(buffer, wait, stop));
    emulator.Receive(std::span<const uint8_t>(buffer).first(count),
                     clock.Now());
  }
  return absl::OkStatus();
}

}  // namespace treeline
