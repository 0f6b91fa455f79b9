// What a Hokuyo sensor sends as arbitrary bytes: no crash, no scan without the
// beams that were asked for, and the same scans however the bytes are cut.
//
// The first byte chooses what is fuzzed: the protocol from its start, or, since
// no fuzzer greets as a sensor does, while it scans.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "nav_agent/drivers/hokuyo/hokuyo_protocol.h"
#include "nav_agent/drivers/hokuyo/scip_codec.h"
#include "nav_agent/drivers/hokuyo/scip_replies.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline {
namespace {

constexpr base::MonotonicTime kStart =
    base::MonotonicTime() + std::chrono::hours(1);

void Say(hokuyo::HokuyoProtocol& protocol, absl::string_view echo,
         absl::string_view rest) {
  protocol.Receive(stream::AsBytes(absl::StrCat(echo, "\n00P\n", rest)),
                   kStart);
}

// Up to the first scan, of ten beams.
void Greet(hokuyo::HokuyoProtocol& protocol) {
  Say(protocol, "QT", "\n");
  Say(protocol, "VV", hokuyo::EncodeVersion({}));
  Say(protocol, "PP",
      hokuyo::EncodeParameters({.last_step = 9, .front_step = 0}));
  Say(protocol, "II", "\n");
  Say(protocol, "BM", "\n");
  Say(protocol, protocol.Command().Text(), "\n");
}

std::vector<core::LaserScan> ScansOf(std::span<const uint8_t> bytes,
                                     bool greeted, size_t chunk) {
  hokuyo::HokuyoOptions options;
  options.time_sync = false;
  hokuyo::HokuyoProtocol protocol(options, kStart);
  if (greeted) Greet(protocol);
  while (!bytes.empty()) {
    const size_t size = std::min(chunk, bytes.size());
    protocol.Receive(bytes.first(size), kStart);
    bytes = bytes.subspan(size);
  }
  std::vector<core::LaserScan> scans = protocol.TakeScans();
  for (const core::LaserScan& scan : scans) {
    if (static_cast<int>(scan.ranges_m.size()) != protocol.Info().beams) {
      std::abort();
    }
    for (const float range_m : scan.ranges_m) {
      if (range_m >= 60.0f && range_m != core::kNoReturn) std::abort();
    }
  }
  protocol.Tick(protocol.NextDeadline());
  return scans;
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const bool greeted = data[0] != '\n';
  const std::span<const uint8_t> bytes(data + (greeted ? 0 : 1),
                                       size - (greeted ? 0 : 1));
  const auto whole = treeline::ScansOf(bytes, greeted, size);
  const auto cut = treeline::ScansOf(bytes, greeted, 1 + data[size - 1] % 17);
  if (whole.size() != cut.size()) std::abort();
  for (size_t i = 0; i < whole.size(); ++i) {
    if (whole[i].stamp != cut[i].stamp) std::abort();
  }
  return 0;
}
