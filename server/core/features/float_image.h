// Pictures in floating point, in grey.
#ifndef SERVER_CORE_FEATURES_FLOAT_IMAGE_H_
#define SERVER_CORE_FEATURES_FLOAT_IMAGE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/image/image.h"

namespace treeline::features {

// Values of a raster. Behind each row is room for a whole vector, so that SIMD
// code need not care where a row ends.
class FloatImage {
 public:
  // Floats of the widest vector.
  static constexpr size_t kSlack = 16;

  // Reuses the allocation; what the values are then is not defined.
  void Resize(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  size_t stride() const { return stride_; }
  float* row(int y) { return data_.data() + static_cast<size_t>(y) * stride_; }
  const float* row(int y) const {
    return data_.data() + static_cast<size_t>(y) * stride_;
  }

 private:
  int width_ = 0;
  int height_ = 0;
  size_t stride_ = 0;
  std::vector<float> data_;
};

// What the channels count for in brightness: it is the weighted sum divided by
// the sum of weights.
struct GrayWeights {
  uint16_t red = 0;
  uint16_t green = 0;
  uint16_t blue = 0;

  constexpr int sum() const { return red + green + blue; }
};
// (R + 2 G + B) / 4.
inline constexpr GrayWeights kPlainGray = {1, 2, 1};
// Rec. 601's, of JPEG and OpenCV: 0.299, 0.587, 0.114.
inline constexpr GrayWeights kLuma = {77, 150, 29};

// The largest n for ReduceToGray, where sums have 16 bits.
constexpr int MaxReduction(const GrayWeights& weights) {
  int n = 1;
  while ((n + 1) * 255 * weights.sum() <= 65535) ++n;
  return n;
}

// The brightness of `image` in a size reduced by n, in [1, MaxReduction()]:
// each pixel is the mean of n x n; what is left over is left out. Pixel (x, y)
// lies at ((x + 0.5) n - 0.5, (y + 0.5) n - 0.5) of the image. row_sums is
// working memory.
void ReduceToGray(const image::ColorImage& image, int n,
                  const GrayWeights& weights, std::vector<uint16_t>& row_sums,
                  FloatImage& gray);

// Twice the size, by linear interpolation: pixel (x, y) lies at
// (x / 2 - 0.25, y / 2 - 0.25) of `in`. Beyond its edges a picture goes on with
// what is there.
void DoubleInSize(const FloatImage& in, FloatImage& doubled);

// Every second pixel of that in both directions: the picture a quarter of a
// pixel further left and up.
void ShiftByQuarter(const FloatImage& in, FloatImage& shifted);

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_FLOAT_IMAGE_H_
