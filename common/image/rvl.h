// RVL, by which depth cameras' recordings pack depth without loss (A. D.
// Wilson, "Fast Lossless Depth Image Compression", 2017): runs of zeros and of
// values that are measured, the latter as differences, all in nibbles of three
// bits and one that says that more follow.
#ifndef COMMON_IMAGE_RVL_H_
#define COMMON_IMAGE_RVL_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/image/decode.h"

namespace treeline::image {

// `bytes`: width and height (32 bits, little-endian), then words of 32 bits,
// little-endian, whose highest nibble is the first. unit_m: metres per unit.
// INVALID_ARGUMENT: it is cut off, has runs that are longer than the picture,
// or a size over the limits or that so few bytes cannot hold.
absl::StatusOr<DepthImage> DecodeRvl(absl::string_view bytes, double unit_m,
                                     const DecodeLimits& limits = {});

}  // namespace treeline::image

#endif  // COMMON_IMAGE_RVL_H_
