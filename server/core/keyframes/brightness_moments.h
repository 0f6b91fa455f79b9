// Whether brightness goes with brightness.
#ifndef SERVER_CORE_KEYFRAMES_BRIGHTNESS_MOMENTS_H_
#define SERVER_CORE_KEYFRAMES_BRIGHTNESS_MOMENTS_H_

#include <cmath>

#include "server/core/keyframes/alignment_kernels.h"

namespace treeline::keyframes {

// Of the brightness that a keyframe says, and of that which is seen.
struct BrightnessMoments {
  ExposureSums sums;
  float yy = 0;

  void Add(float reference, float brightness) {
    const float x = reference - 128;
    const float y = brightness - 128;
    sums += {.w = 1, .x = x, .y = y, .xx = x * x, .xy = x * y};
    yy += y * y;
  }
  BrightnessMoments& operator+=(const BrightnessMoments& other) {
    sums += other.sums;
    yy += other.yy;
    return *this;
  }
  // 0 where hardly anything varies.
  float Correlation() const {
    const float n = sums.w;
    const float vx = sums.xx - sums.x * sums.x / n;
    const float vy = yy - sums.y * sums.y / n;
    if (!(vx > n && vy > n)) return 0;
    return (sums.xy - sums.x * sums.y / n) / std::sqrt(vx * vy);
  }
};

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_BRIGHTNESS_MOMENTS_H_
