// A picture made smaller.
#ifndef SERVER_CORE_FEATURES_GAUSSIAN_SAMPLER_H_
#define SERVER_CORE_FEATURES_GAUSSIAN_SAMPLER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace treeline::features {

// Brightness at the pixels of a coarser grid: the mean of the finer ones around
// each, by a Gaussian. Beyond its edges a picture goes on with what is there.
// Pixel (x, y) lies at ((x + 0.5) / scale - 0.5, (y + 0.5) / scale - 0.5).
class GaussianSampler {
 public:
  // For pictures of width x height (px). `scale` in (0, 1]; sigma_px, which is
  // at least 0.1, in pixels of the coarser grid.
  GaussianSampler(int width, int height, double scale, double sigma_px);

  // Of the coarser grid: scale times the picture's, rounded down.
  int width() const { return static_cast<int>(columns_.first.size()); }
  int height() const { return static_cast<int>(rows_.first.size()); }

  // Row y, in [0, height()), of `gray`, which has the picture's size and rows
  // without gaps. `row` has width() places.
  void Sample(const uint8_t* gray, int y, std::span<float> row);

 private:
  // The pixels that count for each place, from the first on, which may lie
  // before the picture; those that lie beyond the Gaussian weigh nothing.
  struct Taps {
    Taps(int size, double scale, double sigma_px);
    int radius = 0;
    size_t count = 0;  // for each place
    std::vector<int32_t> first;
    std::vector<float> weight;
  };

  int picture_width_;
  int picture_height_;
  Taps columns_;
  Taps rows_;
  std::vector<const uint8_t*> tap_rows_;
  // A row of the picture with what lies beyond its ends.
  std::vector<float> sums_;
};

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_GAUSSIAN_SAMPLER_H_
