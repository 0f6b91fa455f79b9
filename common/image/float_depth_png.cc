#include "common/image/float_depth_png.h"

#include <bit>
#include <cstdint>
#include <vector>

#include "common/base/status_macros.h"
#include "common/image/millimetres.h"
#include "common/image/png_reader.h"

namespace treeline::image {
namespace {

bool IsRgba8(const spng_ihdr& header) {
  return header.bit_depth == 8 &&
         header.color_type == SPNG_COLOR_TYPE_TRUECOLOR_ALPHA;
}

float FloatOf(const uint8_t* rgba) {
  return std::bit_cast<float>(uint32_t{rgba[2]} | uint32_t{rgba[1]} << 8 |
                              uint32_t{rgba[0]} << 16 |
                              uint32_t{rgba[3]} << 24);
}

}  // namespace

bool IsFloatDepthPng(absl::string_view bytes) {
  if (SniffFormat(bytes) != ImageFormat::kPng) return false;
  spng_ihdr header = {};
  return OpenPng(bytes, {}, header).ok() && IsRgba8(header);
}

absl::StatusOr<DepthImage> DecodeFloatDepthPng(absl::string_view bytes,
                                               const DecodeLimits& limits) {
  spng_ihdr header = {};
  TL_ASSIGN_OR_RETURN(const SpngContext context,
                      OpenPng(bytes, limits, header));
  if (!IsRgba8(header)) {
    return absl::InvalidArgumentError(
        "depth image of floats has not four channels of 8 bits");
  }
  std::vector<uint8_t> rgba(size_t{header.width} * header.height * 4);
  TL_RETURN_IF_ERROR(DecodePng(bytes, context.get(), SPNG_FMT_RGBA8,
                               rgba.data(), rgba.size()));
  DepthImage depth{.width = static_cast<int>(header.width),
                   .height = static_cast<int>(header.height),
                   .values = {},
                   .unit_m = 0.001};
  depth.values.reserve(rgba.size() / 4);
  for (size_t i = 0; i < rgba.size(); i += 4) {
    depth.values.push_back(MillimetresOf(FloatOf(rgba.data() + i)));
  }
  return depth;
}

}  // namespace treeline::image
