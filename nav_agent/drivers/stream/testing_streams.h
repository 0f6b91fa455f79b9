// For tests of what lies on byte streams.
#ifndef NAV_AGENT_DRIVERS_STREAM_TESTING_STREAMS_H_
#define NAV_AGENT_DRIVERS_STREAM_TESTING_STREAMS_H_

#include <array>
#include <chrono>
#include <string>

#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::stream {

// Reads until `size` bytes have come, the stream has failed, or nothing more
// came within ten seconds (of which a test that passes sees none).
inline std::string ReadExactly(ByteStream& stream, size_t size) {
  std::string text;
  while (text.size() < size) {
    std::array<uint8_t, 512> buffer = {};
    const size_t wanted = std::min(buffer.size(), size - text.size());
    const auto count = stream.Read(std::span(buffer).first(wanted),
                                   std::chrono::seconds(10), {});
    if (!count.ok() || *count == 0) break;
    text.append(reinterpret_cast<const char*>(buffer.data()), *count);
  }
  return text;
}

}  // namespace treeline::stream

#endif  // NAV_AGENT_DRIVERS_STREAM_TESTING_STREAMS_H_
