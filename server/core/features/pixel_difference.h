// Depth-adaptive colour differences (thesis Eq. 4.2), in integer arithmetic.
#ifndef SERVER_CORE_FEATURES_PIXEL_DIFFERENCE_H_
#define SERVER_CORE_FEATURES_PIXEL_DIFFERENCE_H_

#include <algorithm>
#include <cstdint>

#include "server/core/features/planar_image.h"

namespace treeline::features {

// f(p) = I(p, c1) - I(p + delta / D(p), c2), in [-255, 255].
//
// delta is in quarters of a pixel metre at a focal length of
// kReferenceFocal_px: at depth z (m) the offset is
//   delta / 4 * (f / kReferenceFocal_px) / z  pixels,
// so that a feature looks at the same spot of the scene from any distance and
// through any lens. An offset that leaves the image is clamped to its border.
struct PixelDifference {
  // [-511, 511] each: ten bits in a tree node.
  int16_t dx = 0;
  int16_t dy = 0;
  uint8_t c1 = 0;
  uint8_t c2 = 0;
};

inline constexpr double kReferenceFocal_px = 525;

// (f / kReferenceFocal_px) / z in units of 1/4096, between 1 and 2^16 - 1.
// Integer from here on, so that every machine computes the same features.
inline int32_t InverseDepthQ12(double focal_px, double z_m) {
  const double q = focal_px / kReferenceFocal_px / z_m * 4096;
  return static_cast<int32_t>(std::clamp(q + 0.5, 1.0, 65535.0));
}

// What takes its place in features that know no depth (thesis Eq. 3.2): the
// depth is taken to be 1 m, so that delta / 4 is in pixels.
inline int32_t NoDepthQ12(double focal_px) {
  return InverseDepthQ12(focal_px, 1);
}

inline constexpr int kOffsetShift = 14;  // 12 for Q12, 2 for quarters

inline int32_t OffsetPixels(int32_t delta, int32_t inverse_depth_q12) {
  return (delta * inverse_depth_q12 + (1 << (kOffsetShift - 1))) >>
         kOffsetShift;
}

// The feature at pixel (x, y), which must lie inside the image.
inline int32_t Evaluate(const PixelDifference& feature,
                        const PlanarImage& image, int32_t x, int32_t y,
                        int32_t inverse_depth_q12) {
  const int32_t x2 = std::clamp(x + OffsetPixels(feature.dx, inverse_depth_q12),
                                0, image.width() - 1);
  const int32_t y2 = std::clamp(y + OffsetPixels(feature.dy, inverse_depth_q12),
                                0, image.height() - 1);
  const uint8_t* data = image.data();
  return data[feature.c1 * image.plane_bytes() + y * image.width() + x] -
         data[feature.c2 * image.plane_bytes() + y2 * image.width() + x2];
}

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_PIXEL_DIFFERENCE_H_
