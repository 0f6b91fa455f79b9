// What writer and reader of MCAP share (https://mcap.dev/spec): little-endian
// records of an opcode, a length of eight bytes and content, between two
// magics.
#ifndef COMMON_MCAP_MCAP_FORMAT_H_
#define COMMON_MCAP_MCAP_FORMAT_H_

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "absl/strings/string_view.h"

namespace treeline::mcap {

inline constexpr char kMagic[] = "\x89MCAP0\r\n";
inline constexpr size_t kMagicBytes = 8;
// An opcode and a length.
inline constexpr size_t kRecordHead = 9;

enum class Opcode : uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f
};

template <typename T>
void Put(std::string& to, T value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof(T));
}
inline void PutText(std::string& to, absl::string_view text) {
  Put(to, static_cast<uint32_t>(text.size()));
  to.append(text.data(), text.size());
}
inline void PutRecord(std::string& to, Opcode opcode,
                      absl::string_view content) {
  Put(to, opcode);
  Put(to, static_cast<uint64_t>(content.size()));
  to.append(content.data(), content.size());
}

// Takes values off the front of bytes from outside. After the end everything is
// 0 or empty, and is_good is false.
struct Cursor {
  absl::string_view left;
  bool is_good = true;

  template <typename T>
  T Get() {
    T value{};
    const absl::string_view bytes = GetBytes(sizeof(T));
    if (bytes.size() == sizeof(T)) {
      std::memcpy(&value, bytes.data(), sizeof(T));
    }
    return value;
  }
  absl::string_view GetBytes(uint64_t size) {
    if (size > left.size()) {
      is_good = false;
      left = {};
      return {};
    }
    const absl::string_view bytes = left.substr(0, size);
    left.remove_prefix(size);
    return bytes;
  }
  absl::string_view GetText() { return GetBytes(Get<uint32_t>()); }
};

}  // namespace treeline::mcap

#endif  // COMMON_MCAP_MCAP_FORMAT_H_
