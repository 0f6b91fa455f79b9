#include "server/core/features/scale_space.h"

#include <algorithm>
#include <cmath>

#include "server/core/features/parameters.h"

namespace treeline::features {
namespace {

constexpr size_t kLevels = ScaleSpace::kLayers + 3;
// Rows of a level before it is the next one's turn: those of all levels that
// are read again then lie in the cache.
constexpr int kRowsAtOnce = 16;

// Every second pixel of every second row.
void Decimate(const FloatImage& in, FloatImage& out) {
  out.Resize((in.width() + 1) / 2, (in.height() + 1) / 2);
  for (int y = 0; y < out.height(); ++y) {
    const float* from = in.row(2 * y);
    float* to = out.row(y);
    for (int x = 0; x < out.width(); ++x) to[x] = from[2 * x];
  }
}

}  // namespace

ScaleSpace::ScaleSpace()
    : ScaleSpace(ScaleSpaceOptions{.base_blur_px = kBaseBlur_px,
                                   .picture_blur_px = kPictureBlur_px,
                                   .kernel_reach = kKernelReach,
                                   .min_octave_side_px = kMinOctaveSide_px}) {}

ScaleSpace::ScaleSpace(const ScaleSpaceOptions& options) : options_(options) {
  float before = options_.picture_blur_px;
  for (size_t l = 0; l < kLevels; ++l) {
    const float sigma = Sigma(static_cast<float>(l));
    blurs_.emplace_back(std::sqrt(sigma * sigma - before * before),
                        options_.kernel_reach);
    before = sigma;
  }
}

float ScaleSpace::BlurOfLevel(float base_blur_px, float level) {
  return base_blur_px * std::exp2(level / static_cast<float>(kLayers));
}

int ScaleSpace::ReductionOf(int width, int height) {
  const double pixels = double{1} * width * height;
  return std::clamp(static_cast<int>(std::ceil(
                        std::sqrt(pixels / static_cast<double>(kMaxPixels)))),
                    1, MaxReduction(kPlainGray));
}

// Levels `first` to `last` from the level before, or from the picture. A level
// follows the one before as closely as its blur allows.
void ScaleSpace::Fill(const FloatImage& base, size_t first, size_t last,
                      Octave& octave) {
  const int height = base.height();
  for (size_t l = first; l <= last; ++l) {
    octave.gaussian[l].Resize(base.width(), height);
  }
  std::array<int, kLevels> done{};
  for (int ready = 0; done[last] < height;) {
    ready = std::min(height, ready + kRowsAtOnce);
    int there = ready;
    const FloatImage* in = &base;
    for (size_t l = first; l <= last; ++l) {
      const GaussianBlur& blur = blurs_[l];
      const int end =
          there == height ? height : std::max(done[l], there - blur.radius());
      blur.Rows(*in, done[l], end, octave.gaussian[l], blurred_row_);
      done[l] = there = end;
      in = &octave.gaussian[l];
    }
  }
}

void ScaleSpace::Begin(const FloatImage& picture, double pixel, double origin) {
  octave_count_ = 0;
  pixel_ = pixel;
  origin_ = origin;
  int least = std::min(picture.width(), picture.height());
  for (; least >= options_.min_octave_side_px &&
         octave_count_ < options_.max_octaves;
       least = (least + 1) / 2) {
    if (octave_count_ == octaves_.size()) octaves_.emplace_back();
    Octave& octave = octaves_[octave_count_];
    if (octave_count_ == 0) {
      Fill(picture, 0, kLayers, octave);
    } else {
      Decimate(octaves_[octave_count_ - 1].gaussian[kLayers],
               octave.gaussian[0]);
      Fill(octave.gaussian[0], 1, kLayers, octave);
    }
    ++octave_count_;
  }
}

void ScaleSpace::Complete(size_t octave) {
  Fill(octaves_[octave].gaussian[kLayers], kLayers + 1, kLevels - 1,
       octaves_[octave]);
}

void ScaleSpace::Assign(const image::ColorImage& image, int least_reduction) {
  const int reduction =
      std::clamp(least_reduction, ReductionOf(image.width, image.height),
                 MaxReduction(kPlainGray));
  ReduceToGray(image, reduction, kPlainGray, row_sums_, reduced_);
  // Pixels are means: the first one lies in the middle of those it is of.
  Begin(reduced_, reduction, 0.5 * reduction - 0.5);
  for (size_t o = 0; o < octave_count_; ++o) Complete(o);
}

}  // namespace treeline::features
