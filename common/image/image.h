// Decoded images as plain values.
#ifndef COMMON_IMAGE_IMAGE_H_
#define COMMON_IMAGE_IMAGE_H_

#include <cstdint>
#include <vector>

namespace treeline::image {

// 8-bit colour, interleaved R, G, B, rows from the top without padding:
// channel c of pixel (x, y) is rgb[3 * (y * width + x) + c].
struct ColorImage {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> rgb;
};

// 16-bit depth along the optical axis, rows from the top without padding.
// A value is unit_m metres; 0 and 65535 mean "not measured".
struct DepthImage {
  int width = 0;
  int height = 0;
  std::vector<uint16_t> values;
  double unit_m = 0.001;
};

inline bool IsMeasured(uint16_t depth_value) {
  return depth_value != 0 && depth_value != 65535;
}

}  // namespace treeline::image

#endif  // COMMON_IMAGE_IMAGE_H_
