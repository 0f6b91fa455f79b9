// The brightness of an image, at several resolutions.
#ifndef SERVER_CORE_FEATURES_GRAY_PYRAMID_H_
#define SERVER_CORE_FEATURES_GRAY_PYRAMID_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/core/features/planar_image.h"

namespace treeline::features {

// Level l has (width >> l) x (height >> l) pixels, each the mean of 2 x 2 of
// the level below: pixel (x, y) of level 0 lies at
// ((x + 0.5) / 2^l - 0.5, (y + 0.5) / 2^l - 0.5) of level l.
class GrayPyramid {
 public:
  static constexpr int kLevels = 4;

  struct Level {
    int width = 0;
    int height = 0;
    std::vector<uint8_t> gray;  // rows without gaps

    // Bilinear. (x, y) must lie in [0, width - 1) x [0, height - 1).
    float At(float x, float y) const;
  };

  // Brightness is (R + 2 G + B) / 4. Reuses its allocations.
  void Assign(const PlanarImage& image);

  const Level& level(int l) const { return levels_[static_cast<size_t>(l)]; }

 private:
  std::array<Level, kLevels> levels_;
};

// What GrayPyramid says of a position at level 0, at level l.
inline float AtLevel(float position, int l) {
  return (position + 0.5f) / static_cast<float>(1 << l) - 0.5f;
}

inline float GrayPyramid::Level::At(float x, float y) const {
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const float a = x - static_cast<float>(x0);
  const float b = y - static_cast<float>(y0);
  const uint8_t* p = gray.data() + y0 * width + x0;
  const float top = p[0] + a * static_cast<float>(p[1] - p[0]);
  const float bottom =
      p[width] + a * static_cast<float>(p[width + 1] - p[width]);
  return top + b * (bottom - top);
}

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_GRAY_PYRAMID_H_
