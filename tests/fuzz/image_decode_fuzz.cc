// The image decoders and EXIF on arbitrary bytes: no crash, and what is
// accepted has the size it says.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <string>

#include "absl/strings/string_view.h"
#include "common/image/decode.h"
#include "common/image/exif.h"
#include "common/image/image.h"

namespace treeline {
namespace {

constexpr size_t kPngSignatureBytes = 8;
constexpr size_t kPngChunkOverheadBytes = 12;  // length, type, checksum

// CRC-32 as PNG has it (ISO 3309).
uint32_t Crc32(absl::string_view bytes) {
  uint32_t crc = 0xffffffff;
  for (const char byte : bytes) {
    crc ^= static_cast<uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320 : 0);
    }
  }
  return ~crc;
}

uint32_t BigEndianAt(absl::string_view bytes, size_t at) {
  uint32_t value = 0;
  for (size_t i = 0; i < 4; ++i) {
    value = (value << 8) | static_cast<uint8_t>(bytes[at + i]);
  }
  return value;
}

// The same file with right checksums, so that mutations get past them.
std::string WithPngChecksums(absl::string_view bytes) {
  std::string png(bytes);
  size_t at = kPngSignatureBytes;
  while (at + kPngChunkOverheadBytes <= png.size()) {
    const size_t length = BigEndianAt(png, at);
    if (length > png.size() - at - kPngChunkOverheadBytes) break;
    const size_t checksum_at = at + 8 + length;
    const uint32_t crc =
        Crc32(absl::string_view(png).substr(at + 4, 4 + length));
    for (size_t i = 0; i < 4; ++i) {
      png[checksum_at + i] = static_cast<char>(crc >> (24 - 8 * i));
    }
    at = checksum_at + 4;
  }
  return png;
}

bool HasSizeItSays(int width, int height, size_t values, size_t channels,
                   const image::DecodeLimits& limits) {
  return width >= 1 && width <= limits.max_width && height >= 1 &&
         height <= limits.max_height &&
         int64_t{width} * height <= limits.max_pixels &&
         values == channels * static_cast<size_t>(width * height);
}

void DecodeEveryWay(absl::string_view bytes) {
  const auto turn = image::ReadExifUprightTurn(bytes);
  if (turn.has_value() &&
      (image::SniffFormat(bytes) != image::ImageFormat::kJpeg ||
       !std::count(std::begin(image::kQuarterTurns),
                   std::end(image::kQuarterTurns), *turn))) {
    std::abort();
  }
  const auto focal_mm = image::ReadExifFocal35_mm(bytes);
  if (focal_mm.has_value() && !(*focal_mm >= 1 && *focal_mm <= 65535)) {
    std::abort();
  }
  const image::DecodeLimits limits{
      .max_width = 512, .max_height = 512, .max_pixels = 1 << 16};
  const auto color = image::DecodeColor(bytes, limits);
  if (color.ok() && !HasSizeItSays(color->width, color->height,
                                   color->rgb.size(), 3, limits)) {
    std::abort();
  }
  const auto depth = image::DecodeDepthPng(bytes, /*unit_m=*/0.001, limits);
  if (depth.ok() && !HasSizeItSays(depth->width, depth->height,
                                   depth->values.size(), 1, limits)) {
    std::abort();
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  treeline::DecodeEveryWay(bytes);
  if (treeline::image::SniffFormat(bytes) ==
      treeline::image::ImageFormat::kPng) {
    treeline::DecodeEveryWay(treeline::WithPngChecksums(bytes));
  }
  return 0;
}
