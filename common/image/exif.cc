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
constexpr uint32_t kExifDirectoryTag = 0x8769;
constexpr uint32_t kFocal35Tag = 0xa405;
// Types.
constexpr uint32_t kShort = 3;
constexpr uint32_t kLong = 4;

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

class Tiff {
 public:
  // nullopt: it is none.
  static std::optional<Tiff> Of(absl::string_view bytes) {
    const bool little = absl::StartsWith(bytes, kLittleEndian);
    if (!little && !absl::StartsWith(bytes, kBigEndian)) return std::nullopt;
    return Tiff(bytes, little);
  }

  std::optional<uint32_t> FirstDirectory() const { return Number(4, 4); }

  // The only value, of type `type`, of a tag of the directory that begins at
  // `directory`.
  std::optional<uint32_t> Find(uint32_t directory, uint32_t wanted,
                               uint32_t type) const {
    const std::optional<uint32_t> tags = Number(directory, 2);
    if (!tags || *tags > kMaxTags) return std::nullopt;
    for (size_t i = 0; i < *tags; ++i) {
      const size_t at = size_t{directory} + 2 + i * kTagBytes;
      const std::optional<uint32_t> tag = Number(at, 2);
      if (!tag) return std::nullopt;
      if (*tag != wanted) continue;
      if (Number(at + 2, 2) != type || Number(at + 4, 4) != 1u) {
        return std::nullopt;
      }
      return Number(at + 8, type == kShort ? 2 : 4);
    }
    return std::nullopt;
  }

 private:
  Tiff(absl::string_view bytes, bool little) : bytes_(bytes), little_(little) {}

  std::optional<uint32_t> Number(size_t at, size_t bytes) const {
    return ReadNumber(bytes_, at, bytes, little_);
  }

  absl::string_view bytes_;
  bool little_;
};

// The content of the first EXIF segment.
std::optional<Tiff> FindExif(absl::string_view jpeg) {
  if (!absl::ConsumePrefix(&jpeg, kStartOfImage)) return std::nullopt;
  for (int i = 0; i < kMaxSegments; ++i) {
    std::optional<Segment> segment = TakeSegment(jpeg);
    if (!segment) return std::nullopt;
    if (segment->marker == kApp1 &&
        absl::ConsumePrefix(&segment->content, kExif)) {
      return Tiff::Of(segment->content);
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<QuarterTurn> ReadExifUprightTurn(absl::string_view jpeg) {
  const std::optional<Tiff> exif = FindExif(jpeg);
  if (!exif) return std::nullopt;
  const std::optional<uint32_t> directory = exif->FirstDirectory();
  if (!directory) return std::nullopt;
  // What the first row and the first column of the pixels show.
  switch (exif->Find(*directory, kOrientationTag, kShort).value_or(0)) {
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

std::optional<double> ReadExifFocal35_mm(absl::string_view jpeg) {
  const std::optional<Tiff> exif = FindExif(jpeg);
  if (!exif) return std::nullopt;
  std::optional<uint32_t> directory = exif->FirstDirectory();
  if (directory) directory = exif->Find(*directory, kExifDirectoryTag, kLong);
  if (!directory) return std::nullopt;
  const std::optional<uint32_t> focal =
      exif->Find(*directory, kFocal35Tag, kShort);
  if (!focal || *focal == 0) return std::nullopt;
  return *focal;
}

}  // namespace treeline::image
