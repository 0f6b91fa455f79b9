// Depth in metres, as floats, to the millimetres of depth images.
#ifndef COMMON_IMAGE_MILLIMETRES_H_
#define COMMON_IMAGE_MILLIMETRES_H_

#include <cmath>
#include <cstdint>

namespace treeline::image {

// Not measured (0): what is not positive, not a number, or further than 65.534
// m, the largest that a depth image holds.
inline uint16_t MillimetresOf(float depth_m) {
  constexpr float kFarthest_m = 65.534F;
  if (!(depth_m > 0) || depth_m > kFarthest_m) return 0;
  return static_cast<uint16_t>(std::lround(depth_m * 1000));
}

}  // namespace treeline::image

#endif  // COMMON_IMAGE_MILLIMETRES_H_
