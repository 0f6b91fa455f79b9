// What an HTTP/2 client asks of a server, counted from its bytes before the
// server sees them.
#ifndef COMMON_FLOOD_GUARD_FRAME_COUNTER_H_
#define COMMON_FLOOD_GUARD_FRAME_COUNTER_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "absl/strings/string_view.h"

namespace treeline::flood_guard {

// Of some bytes of one connection.
struct FrameCounts {
  // Calls that begin. A block of headers counts once more for each
  // kBytesOfACall in it, since headers cost about as much.
  int64_t calls = 0;
  // All other frames but DATA that carries kMinPayload bytes or more.
  int64_t frames = 0;
  // What has arrived in DATA.
  int64_t payload_bytes = 0;

  friend bool operator==(const FrameCounts&, const FrameCounts&) = default;
};

// Reads the 9 bytes before each frame (RFC 9113, section 4.1) of what a client
// sends, and skips what follows them. Bytes may arrive in pieces of any size;
// what is counted does not depend on it. What does not begin with the client's
// preface is no HTTP/2, and nothing of it is counted: the server ends it. Not
// thread-safe.
class FrameCounter {
 public:
  static constexpr int64_t kBytesOfACall = 4096;
  // Smaller pieces of a message cost the server more than they bring.
  static constexpr uint32_t kMinPayload = 128;
  // gRPC refuses a call whose headers hold more than 8 or 16 KiB, but reads
  // them, however many there are.
  static constexpr int64_t kMaxHeaderBlock = 64 * 1024;

  // Adds what is in the next bytes; false: the headers of a call are over
  // kMaxHeaderBlock (CVE-2024-27316), and nothing counts from then on.
  bool Count(absl::string_view bytes, FrameCounts& counts);

 private:
  static constexpr size_t kHeadBytes = 9;

  // Both take what is theirs from the front of `bytes`.
  void TakePreface(absl::string_view& bytes);
  void TakeHead(absl::string_view& bytes, FrameCounts& counts);
  // The head is whole.
  void Begin(FrameCounts& counts);
  void BeginHeaders(uint32_t length, FrameCounts& counts);

  bool is_http2_ = true;
  size_t preface_bytes_ = 0;
  std::array<unsigned char, kHeadBytes> head_ = {};
  size_t head_bytes_ = 0;
  // Of the frame, still to come.
  uint32_t payload_left_ = 0;
  bool is_data_ = false;
  // Of the headers that are arriving, so far.
  int64_t block_bytes_ = 0;
  bool is_headers_without_end_ = false;
};

}  // namespace treeline::flood_guard

#endif  // COMMON_FLOOD_GUARD_FRAME_COUNTER_H_
