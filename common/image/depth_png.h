// The PNG files that depth cameras write, read and written in less than half of
// the time that a general library takes.
#ifndef COMMON_IMAGE_DEPTH_PNG_H_
#define COMMON_IMAGE_DEPTH_PNG_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace treeline::image {

// What a plain PNG (16-bit grey, not interlaced) says of itself.
struct PlainDepthPng {
  int width = 0;
  int height = 0;
  std::vector<uint16_t> values;  // host byte order, rows from the top
};

// Decodes a plain PNG of at most max_pixels, all checksums verified. nullopt
// for anything else, whether broken or only unusual: a general reader knows
// which.
std::optional<PlainDepthPng> DecodePlainDepthPng(absl::string_view bytes,
                                                 int64_t max_pixels);

// The PNG of width * height values. Rows are not filtered: sensors know few
// depths, which repeat as they are, and which filters would tell apart.
std::string EncodePlainDepthPng(int width, int height,
                                std::span<const uint16_t> values);

}  // namespace treeline::image

#endif  // COMMON_IMAGE_DEPTH_PNG_H_
