// Many colour differences at one pixel, side by side: what growing a tree asks.
#ifndef SERVER_CORE_FEATURES_PIXEL_DIFFERENCE_BLOCKS_H_
#define SERVER_CORE_FEATURES_PIXEL_DIFFERENCE_BLOCKS_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "server/core/features/pixel_difference.h"
#include "server/core/features/planar_image.h"

namespace treeline::features {

// Sixteen features, member by member.
struct PixelDifferenceBlock {
  static constexpr size_t kFeatures = 16;

  int16_t dx[kFeatures] = {};
  int16_t dy[kFeatures] = {};
  uint8_t c1[kFeatures] = {};
  uint8_t c2[kFeatures] = {};

  void Set(size_t i, const PixelDifference& feature) {
    dx[i] = feature.dx;
    dy[i] = feature.dy;
    c1[i] = feature.c1;
    c2[i] = feature.c2;
  }
  PixelDifference Get(size_t i) const { return {dx[i], dy[i], c1[i], c2[i]}; }
};

// values[k] is Evaluate() of feature k % 16 of block k / 16 at (x, y), which
// must lie inside the image. values has kFeatures slots for each block.
void EvaluateBlocks(std::span<const PixelDifferenceBlock> blocks,
                    const PlanarImage& image, int32_t x, int32_t y,
                    int32_t inverse_depth_q12, std::span<int16_t> values);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_PIXEL_DIFFERENCE_BLOCKS_H_
