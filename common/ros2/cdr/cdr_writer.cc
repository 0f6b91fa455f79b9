#include "common/ros2/cdr/cdr_writer.h"

#include <bit>

namespace treeline::cdr {

// Values are copied as they lie in memory.
static_assert(std::endian::native == std::endian::little);

namespace {
constexpr size_t kEncodingBytes = 4;
}  // namespace

CdrWriter::CdrWriter() : bytes_({0x00, 0x01, 0x00, 0x00}) {}

void CdrWriter::WriteString(absl::string_view text) {
  WriteCount(text.size() + 1);
  Append(text.data(), text.size());
  bytes_.push_back(0);
}

void CdrWriter::Align(size_t size) {
  const size_t at = bytes_.size() - kEncodingBytes;
  bytes_.resize(bytes_.size() + (size - at % size) % size);
}

void CdrWriter::Append(const void* data, size_t size) {
  const auto* bytes = static_cast<const uint8_t*>(data);
  bytes_.insert(bytes_.end(), bytes, bytes + size);
}

}  // namespace treeline::cdr
