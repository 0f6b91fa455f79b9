// The scale space of a picture (Lowe 2004, section 3): its brightness, blurred
// more and more.
#ifndef SERVER_CORE_FEATURES_SCALE_SPACE_H_
#define SERVER_CORE_FEATURES_SCALE_SPACE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/image.h"
#include "server/core/features/float_image.h"
#include "server/core/features/gaussian_blur.h"

namespace treeline::features {

struct ScaleSpaceOptions {
  // Of the finest level, in pixels of its octave, ...
  float base_blur_px = 0;
  // ... and what a picture has of itself: less.
  float picture_blur_px = 0;
  // Standard deviations at which a Gaussian is cut off.
  float kernel_reach = 0;
  // Octaves that are smaller than this, at least 2, on a side are left out, ...
  int min_octave_side_px = 2;
  // ... and those above so many.
  size_t max_octaves = SIZE_MAX;
};

// Octave o has every 2^o-th pixel of a picture in both directions.
class ScaleSpace {
 public:
  // Layers of an octave in which features are found; blur doubles over them.
  static constexpr int kLayers = 3;

  struct Octave {
    // Level l is blurred by Sigma(l) of the octave's pixels. Features stand on
    // the differences of neighbouring levels; difference l is level l + 1 less
    // level l.
    std::array<FloatImage, kLayers + 3> gaussian;

    int width() const { return gaussian[0].width(); }
    int height() const { return gaussian[0].height(); }
  };

  // FastSift's.
  ScaleSpace();
  explicit ScaleSpace(const ScaleSpaceOptions& options);

  // Pictures are looked at in a reduced size, so that time does not grow with
  // them: reduced by their size, and by no less than least_reduction. Levels
  // are all there. Reuses its allocations.
  void Assign(const image::ColorImage& image, int least_reduction = 1);
  // By how many a picture of this size is reduced.
  static int ReductionOf(int width, int height);

  // All octaves of a picture in grey, with those levels that the next octave
  // takes: 0 to kLayers. Pixel x of the picture lies at pixel * x + origin of
  // the image, in both directions. Reuses its allocations. `picture` is not
  // needed afterwards.
  void Begin(const FloatImage& picture, double pixel, double origin);
  // ... and the other levels of one octave, once.
  void Complete(size_t octave);

  std::span<const Octave> octaves() const {
    return {octaves_.data(), octave_count_};
  }
  // A pixel of octave 0 in pixels of the image.
  double pixel() const { return pixel_; }

  // The blur of a level, which may lie between two, in pixels of its octave.
  float Sigma(float level) const {
    return BlurOfLevel(options_.base_blur_px, level);
  }
  // The same for a blur of level 0.
  static float BlurOfLevel(float base_blur_px, float level);
  // Position x of octave o in the image. Pixel centres are at integer
  // coordinates in both, see docs/frames.md.
  double InImage(float x, size_t octave) const {
    return static_cast<double>(x) * static_cast<double>(1u << octave) * pixel_ +
           origin_;
  }
  // ... and where a position in the image lies in octave o.
  float InOctave(double x, size_t octave) const {
    return static_cast<float>((x - origin_) / pixel_ /
                              static_cast<double>(1u << octave));
  }

 private:
  void Fill(const FloatImage& base, size_t first, size_t last, Octave& octave);

  ScaleSpaceOptions options_;
  // Blur l takes level l - 1 to level l; blur 0 the picture to level 0.
  std::vector<GaussianBlur> blurs_;
  double pixel_ = 1;
  double origin_ = 0;
  size_t octave_count_ = 0;
  std::vector<Octave> octaves_;
  FloatImage reduced_;
  std::vector<uint16_t> row_sums_;
  std::vector<float> blurred_row_;
};

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_SCALE_SPACE_H_
