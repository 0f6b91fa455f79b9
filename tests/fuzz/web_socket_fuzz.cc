// Frames of a WebSocket as arbitrary bytes: no crash; the same events however
// the bytes arrive; messages stay within their limit, and within the room that
// was asked for.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/http/web_socket.h"

namespace {

using treeline::http::WebSocketReader;

constexpr size_t kMaxBytes = 1 << 16;
// Short ones are held in the string itself.
constexpr size_t kInString = 32;

void Check(bool holds) {
  if (!holds) std::abort();
}

std::vector<std::string> EventsOf(absl::string_view bytes, size_t step) {
  size_t room = 0;
  WebSocketReader reader(kMaxBytes, [&room](size_t wanted) {
    Check(wanted <= kMaxBytes);
    room = std::max(room, wanted);
    return true;
  });
  std::vector<std::string> events;
  while (!bytes.empty()) {
    absl::string_view piece = bytes.substr(0, step);
    bytes.remove_prefix(piece.size());
    while (!piece.empty()) {
      const size_t before = piece.size();
      const WebSocketReader::Event event = reader.Read(piece);
      switch (event) {
        case WebSocketReader::Event::kNone:
          Check(piece.empty());
          break;
        case WebSocketReader::Event::kMessage:
          Check(!reader.is_amid());
          events.push_back(reader.TakeMessage());
          Check(events.back().size() <= std::max(room, kInString));
          break;
        case WebSocketReader::Event::kPing:
          Check(reader.ping().size() <= 125);
          events.push_back("ping" + reader.ping());
          break;
        case WebSocketReader::Event::kClose:
          events.emplace_back("close");
          break;
        case WebSocketReader::Event::kFailed:
          events.push_back(std::to_string(static_cast<int>(reader.failure())));
          return events;
      }
      Check(event == WebSocketReader::Event::kNone || piece.size() < before);
    }
  }
  return events;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  Check(EventsOf(bytes, size) == EventsOf(bytes, 1 + data[0] % 7));
  return 0;
}
