#include "common/flood_guard/frame_counter.h"

#include <algorithm>

namespace treeline::flood_guard {
namespace {

constexpr absl::string_view kPreface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

// RFC 9113, section 6.
constexpr unsigned char kData = 0x0;
constexpr unsigned char kHeaders = 0x1;
constexpr unsigned char kContinuation = 0x9;

}  // namespace

bool FrameCounter::Count(absl::string_view bytes, FrameCounts& counts) {
  while (!bytes.empty() && is_http2_ && !is_headers_without_end_) {
    if (preface_bytes_ < kPreface.size()) {
      TakePreface(bytes);
    } else if (payload_left_ > 0) {
      const size_t skipped = std::min<size_t>(payload_left_, bytes.size());
      payload_left_ -= static_cast<uint32_t>(skipped);
      if (is_data_) counts.payload_bytes += static_cast<int64_t>(skipped);
      bytes.remove_prefix(skipped);
    } else {
      TakeHead(bytes, counts);
    }
  }
  return !is_headers_without_end_;
}

void FrameCounter::TakePreface(absl::string_view& bytes) {
  const absl::string_view expected = kPreface.substr(preface_bytes_);
  const size_t size = std::min(expected.size(), bytes.size());
  is_http2_ = bytes.substr(0, size) == expected.substr(0, size);
  preface_bytes_ += size;
  bytes.remove_prefix(size);
}

void FrameCounter::TakeHead(absl::string_view& bytes, FrameCounts& counts) {
  const size_t size = std::min(kHeadBytes - head_bytes_, bytes.size());
  std::copy_n(bytes.data(), size, head_.begin() + head_bytes_);
  head_bytes_ += size;
  bytes.remove_prefix(size);
  if (head_bytes_ < kHeadBytes) return;
  head_bytes_ = 0;
  Begin(counts);
}

void FrameCounter::Begin(FrameCounts& counts) {
  const uint32_t length = static_cast<uint32_t>(head_[0]) << 16 |
                          static_cast<uint32_t>(head_[1]) << 8 | head_[2];
  payload_left_ = length;
  is_data_ = head_[3] == kData;
  switch (head_[3]) {
    case kHeaders:
      block_bytes_ = 0;
      ++counts.calls;
      BeginHeaders(length, counts);
      return;
    case kContinuation:
      ++counts.frames;
      BeginHeaders(length, counts);
      return;
    case kData:
      if (length < kMinPayload) ++counts.frames;
      return;
    default:
      ++counts.frames;
  }
}

void FrameCounter::BeginHeaders(uint32_t length, FrameCounts& counts) {
  const int64_t before = block_bytes_ / kBytesOfACall;
  block_bytes_ += length;
  counts.calls += block_bytes_ / kBytesOfACall - before;
  is_headers_without_end_ = block_bytes_ > kMaxHeaderBlock;
}

}  // namespace treeline::flood_guard
