// The colour image as the features read it: three planes.
#ifndef SERVER_CORE_FEATURES_PLANAR_IMAGE_H_
#define SERVER_CORE_FEATURES_PLANAR_IMAGE_H_

#include <cstdint>
#include <vector>

#include "common/image/image.h"

namespace treeline::features {

// Red, green and blue planes one after the other in one allocation, rows
// without gaps. Sixty-four readable bytes follow the last plane, so that SIMD
// code may load whole vectors anywhere.
class PlanarImage {
 public:
  static constexpr int kPadding_bytes = 64;

  PlanarImage() = default;
  explicit PlanarImage(const image::ColorImage& image) { Assign(image); }

  // Replaces the contents, reusing the allocation.
  void Assign(const image::ColorImage& image);

  int width() const { return width_; }
  int height() const { return height_; }
  int plane_bytes() const { return width_ * height_; }
  // Channel 0 (red), 1 or 2 of pixel (x, y) is
  // data()[channel * plane_bytes() + y * width() + x].
  const uint8_t* data() const { return data_.data(); }

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<uint8_t> data_;
};

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_PLANAR_IMAGE_H_
