// Depth as floats whose four bytes are the channels of a PNG of 8 bits.
#ifndef COMMON_IMAGE_FLOAT_DEPTH_PNG_H_
#define COMMON_IMAGE_FLOAT_DEPTH_PNG_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/image/decode.h"

namespace treeline::image {

// Whether the header is that of a PNG with red, green, blue and alpha of 8 bits
// each, which no depth in whole numbers has.
bool IsFloatDepthPng(absl::string_view bytes);

// Depth in mm (unit_m is 0.001) of floats in metres: those that are not
// positive, not finite or over 65.534 m become 0. The bytes of a float, the
// least first, are blue, green, red and alpha, as OpenCV writes a matrix of
// floats that it takes for one of BGRA (rtabmap, compressImage in
// corelib/src/Compression.cpp). INVALID_ARGUMENT: it is no such PNG, is broken,
// or is over the limits.
absl::StatusOr<DepthImage> DecodeFloatDepthPng(absl::string_view bytes,
                                               const DecodeLimits& limits = {});

}  // namespace treeline::image

#endif  // COMMON_IMAGE_FLOAT_DEPTH_PNG_H_
