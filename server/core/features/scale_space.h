// The scale space of a picture (Lowe 2004, section 3): its brightness, blurred
// more and more, and the differences of neighbouring blurs.
#ifndef SERVER_CORE_FEATURES_SCALE_SPACE_H_
#define SERVER_CORE_FEATURES_SCALE_SPACE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/image.h"

namespace treeline::features {

// Values of a raster. Behind each row is room for a whole vector, so that SIMD
// code need not care where a row ends.
class FloatImage {
 public:
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

// Pictures are looked at in a reduced size, each pixel the mean of n x n, so
// that time does not grow with them. Octave o has every 2^o-th of these pixels
// in both directions.
class ScaleSpace {
 public:
  // Layers of an octave in which features are found; blur doubles over them.
  static constexpr int kLayers = 3;

  struct Octave {
    // Level l is blurred by Sigma(l) of the octave's pixels.
    std::array<FloatImage, kLayers + 3> gaussian;
    // Level l is gaussian[l + 1] - gaussian[l].
    std::array<FloatImage, kLayers + 2> difference;
  };

  // Brightness is (R + 2 G + B) / 4. The picture is reduced by its size, and by
  // no less than least_reduction. Reuses its allocations.
  void Assign(const image::ColorImage& image, int least_reduction = 1);
  // By how many a picture of this size is reduced.
  static int ReductionOf(int width, int height);

  std::span<const Octave> octaves() const {
    return {octaves_.data(), octave_count_};
  }
  // Pixels of the picture in one of octave 0, a side.
  int reduction() const { return reduction_; }

  // The blur of a level, which may lie between two, in pixels of its octave.
  static float Sigma(float level);
  // Position x of octave o in the picture. Pixel centres are at integer
  // coordinates in both, see docs/frames.md.
  double InPicture(float x, size_t octave) const {
    return (static_cast<double>(x) * static_cast<double>(1u << octave) + 0.5) *
               reduction_ -
           0.5;
  }

 private:
  void Reduce(const image::ColorImage& image, FloatImage& reduced);

  int reduction_ = 1;
  size_t octave_count_ = 0;
  std::vector<Octave> octaves_;
  FloatImage reduced_;
  std::vector<uint16_t> row_sums_;
  std::vector<float> blurred_row_;
};

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_SCALE_SPACE_H_
