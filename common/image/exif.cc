#include "common/image/exif.h"

#include <cstddef>
#include <cstdint>

#include "absl/strings/match.h"
#include "absl/strings/strip.h"

namespace treeline::image {
namespace {

constexpr int kMaxSegments = 64;
constexpr uint32_t kMaxTags = 256;

// Markers of JPEG (ITU T.81, table B.1), after their 0xff.
constexpr absl::string_view kStartOfImage("\xff\xd8", 2);
constexpr uint8_t kFill = 0xff;
constexpr uint8_t kApp1 = 0xe1;
constexpr uint8_t kStartOfScan = 0xda;
constexpr uint8_t kEndOfImage = 0xd9;
constexpr absl::string_view kExif("Exif\0\0", 6);

// TIFF.
constexpr absl::string_view kLittleEndian("II*\0", 4);
constexpr absl::string_view kBigEndian("MM\0*", 4);
constexpr size_t kTagBytes = 12;
constexpr uint32_t kOrientationTag = 0x0112;
constexpr uint32_t kShort = 3;

// A number of `bytes` bytes at `at`; nullopt beyond the end.
std::optional<uint32_t> ReadNumber(absl::string_view data, size_t at,
                                   size_t bytes, bool is_little_endian) {
  if (at > data.size() || bytes > data.size() - at) return std::nullopt;
  uint32_t value = 0;
  for (size_t i = 0; i < bytes; ++i) {
    const size_t from = is_little_endian ? at + bytes - 1 - i : at + i;
    value = value << 8 | static_cast<uint8_t>(data[from]);
  }
  return value;
}

// Takes a segment with its marker off the front; nullopt where the picture
// begins, and where there is none.
struct Segment {
  uint8_t marker = 0;
  absl::string_view content;
};
std::optional<Segment> TakeSegment(absl::string_view& rest) {
  if (!absl::ConsumePrefix(&rest, "\xff")) return std::nullopt;
  while (!rest.empty() && static_cast<uint8_t>(rest[0]) == kFill) {
    rest.remove_prefix(1);
  }
  if (rest.empty()) return std::nullopt;
  Segment segment{.marker = static_cast<uint8_t>(rest[0]), .content = {}};
  rest.remove_prefix(1);
  if (segment.marker == kStartOfScan || segment.marker == kEndOfImage) {
    return std::nullopt;
  }
  // The length counts its own two bytes.
  const std::optional<uint32_t> length = ReadNumber(rest, 0, 2, false);
  if (!length || *length < 2 || *length > rest.size()) return std::nullopt;
  segment.content = rest.substr(2, *length - 2);
  rest.remove_prefix(*length);
  return segment;
}

// The value of the tag Orientation in the first directory.
std::optional<uint32_t> OrientationTag(absl::string_view tiff) {
  const bool little = absl::StartsWith(tiff, kLittleEndian);
  if (!little && !absl::StartsWith(tiff, kBigEndian)) return std::nullopt;
  const std::optional<uint32_t> directory = ReadNumber(tiff, 4, 4, little);
  if (!directory) return std::nullopt;
  const std::optional<uint32_t> tags = ReadNumber(tiff, *directory, 2, little);
  if (!tags || *tags > kMaxTags) return std::nullopt;
  for (size_t i = 0; i < *tags; ++i) {
    const size_t at = *directory + 2 + i * kTagBytes;
    const std::optional<uint32_t> tag = ReadNumber(tiff, at, 2, little);
    if (!tag) return std::nullopt;
    if (*tag != kOrientationTag) continue;
    if (ReadNumber(tiff, at + 2, 2, little) != kShort ||
        ReadNumber(tiff, at + 4, 4, little) != 1u) {
      return std::nullopt;
    }
    return ReadNumber(tiff, at + 8, 2, little);
  }
  return std::nullopt;
}

}  // namespace

std::optional<QuarterTurn> ReadExifUprightTurn(absl::string_view jpeg) {
  if (!absl::ConsumePrefix(&jpeg, kStartOfImage)) return std::nullopt;
  for (int i = 0; i < kMaxSegments; ++i) {
    std::optional<Segment> segment = TakeSegment(jpeg);
    if (!segment) return std::nullopt;
    if (segment->marker != kApp1 ||
        !absl::ConsumePrefix(&segment->content, kExif)) {
      continue;
    }
    // What the first row and the first column of the pixels show.
    switch (OrientationTag(segment->content).value_or(0)) {
      case 1:  // top, left
        return QuarterTurn::kNone;
      case 3:  // bottom, right
        return QuarterTurn::kHalf;
      case 6:  // right, top
        return QuarterTurn::kClockwise;
      case 8:  // left, bottom
        return QuarterTurn::kCounterclockwise;
      default:
        return std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace treeline::image
