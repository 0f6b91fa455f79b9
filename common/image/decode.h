// Encoded images -> decoded images, with limits checked before any allocation.
#ifndef COMMON_IMAGE_DECODE_H_
#define COMMON_IMAGE_DECODE_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/image/image.h"

namespace treeline::image {

// Larger images are refused with INVALID_ARGUMENT before they are decoded.
struct DecodeLimits {
  int max_width = 8192;
  int max_height = 8192;
  int64_t max_pixels = 32 << 20;
};

enum class ImageFormat { kUnknown, kJpeg, kPng };

// By magic bytes, never by name.
ImageFormat SniffFormat(absl::string_view bytes);

struct ImageSize {
  int width = 0;
  int height = 0;

  bool operator==(const ImageSize&) const = default;
};

// The size in the header of a JPEG or PNG, without decoding it.
// INVALID_ARGUMENT if there is no readable header or the size is over the
// limits.
absl::StatusOr<ImageSize> ReadImageSize(absl::string_view bytes,
                                        const DecodeLimits& limits = {});

// JPEG (grey or colour, baseline or progressive) or PNG (any colour type, 8 or
// 16 bit; alpha is dropped). Grey becomes R = G = B. INVALID_ARGUMENT, with
// the reason, for anything truncated, corrupt or over the limits.
absl::StatusOr<ColorImage> DecodeColor(absl::string_view bytes,
                                       const DecodeLimits& limits = {});

// 16-bit grey PNG. unit_m: metres per unit, as stated by whoever sent it.
absl::StatusOr<DepthImage> DecodeDepthPng(absl::string_view bytes,
                                          double unit_m,
                                          const DecodeLimits& limits = {});

// quality in 1..100; 4:2:0 below 95, 4:4:4 from there.
absl::StatusOr<std::string> EncodeJpeg(const ColorImage& image, int quality);
absl::StatusOr<std::string> EncodePng(const ColorImage& image);
absl::StatusOr<std::string> EncodeDepthPng(const DepthImage& image);

}  // namespace treeline::image

#endif  // COMMON_IMAGE_DECODE_H_
