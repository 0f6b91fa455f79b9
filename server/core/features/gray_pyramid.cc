#include "server/core/features/gray_pyramid.h"

namespace treeline::features {

void GrayPyramid::Assign(const PlanarImage& image) {
  Level& full = levels_[0];
  full.width = image.width();
  full.height = image.height();
  const size_t pixels = static_cast<size_t>(image.plane_bytes());
  full.gray.resize(pixels);
  const uint8_t* red = image.data();
  const uint8_t* green = red + pixels;
  const uint8_t* blue = green + pixels;
  for (size_t i = 0; i < pixels; ++i) {
    full.gray[i] =
        static_cast<uint8_t>((red[i] + 2 * green[i] + blue[i] + 2) / 4);
  }
  for (size_t l = 1; l < kLevels; ++l) {
    const Level& below = levels_[l - 1];
    Level& level = levels_[l];
    level.width = below.width / 2;
    level.height = below.height / 2;
    level.gray.resize(static_cast<size_t>(level.width) *
                      static_cast<size_t>(level.height));
    for (int y = 0; y < level.height; ++y) {
      const uint8_t* top = below.gray.data() + 2 * y * below.width;
      const uint8_t* bottom = top + below.width;
      uint8_t* out = level.gray.data() + y * level.width;
      for (int x = 0; x < level.width; ++x) {
        out[x] = static_cast<uint8_t>((top[2 * x] + top[2 * x + 1] +
                                       bottom[2 * x] + bottom[2 * x + 1] + 2) /
                                      4);
      }
    }
  }
}

}  // namespace treeline::features
