#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/scale_space.cc"
#include "server/core/features/scale_space.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Adds R + 2 G + B of each pixel to sums, or stores it if `first`.
void AddGray(const uint8_t* rgb, size_t pixels, bool first, uint16_t* sums) {
  const hn::ScalableTag<uint16_t> d16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const size_t lanes = hn::Lanes(d16);
  size_t i = 0;
  for (; i + lanes <= pixels; i += lanes) {
    hn::Vec<decltype(d8)> r, g, b;
    hn::LoadInterleaved3(d8, rgb + 3 * i, r, g, b);
    auto sum = hn::Add(hn::Add(hn::PromoteTo(d16, r), hn::PromoteTo(d16, b)),
                       hn::ShiftLeft<1>(hn::PromoteTo(d16, g)));
    if (!first) sum = hn::Add(sum, hn::LoadU(d16, sums + i));
    hn::StoreU(sum, d16, sums + i);
  }
  for (; i < pixels; ++i) {
    const int gray = rgb[3 * i] + 2 * rgb[3 * i + 1] + rgb[3 * i + 2];
    sums[i] = static_cast<uint16_t>((first ? 0 : sums[i]) + gray);
  }
}

// Convolves with the symmetric kernel of which taps[k] stands k from the
// middle, along both axes; beyond its edges the image goes on with what is
// there. `row` has room for a row, taps.size() and a vector on either side.
// `difference`, if not null, becomes out - in.
void Blur(const FloatImage& in, const float* taps, int radius, float* row,
          FloatImage& out, FloatImage* difference) {
  const hn::CappedTag<float, 16> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int width = in.width();
  const int last = in.height() - 1;
  float* const middle = row + radius + lanes;
  for (int y = 0; y <= last; ++y) {
    const float* const at = in.row(y);
    for (int x = 0; x < width; x += lanes) {
      auto sum = hn::Mul(hn::LoadU(d, at + x), hn::Set(d, taps[0]));
      for (int k = 1; k <= radius; ++k) {
        const float* above = in.row(y - k < 0 ? 0 : y - k);
        const float* below = in.row(y + k > last ? last : y + k);
        sum = hn::MulAdd(
            hn::Add(hn::LoadU(d, above + x), hn::LoadU(d, below + x)),
            hn::Set(d, taps[k]), sum);
      }
      hn::StoreU(sum, d, middle + x);
    }
    for (int k = 1; k <= radius; ++k) {
      middle[-k] = middle[0];
      middle[width - 1 + k] = middle[width - 1];
    }
    float* const to = out.row(y);
    float* const gap = difference == nullptr ? nullptr : difference->row(y);
    for (int x = 0; x < width; x += lanes) {
      auto sum = hn::Mul(hn::LoadU(d, middle + x), hn::Set(d, taps[0]));
      for (int k = 1; k <= radius; ++k) {
        sum = hn::MulAdd(
            hn::Add(hn::LoadU(d, middle + x - k), hn::LoadU(d, middle + x + k)),
            hn::Set(d, taps[k]), sum);
      }
      hn::StoreU(sum, d, to + x);
      if (gap != nullptr) {
        hn::StoreU(hn::Sub(sum, hn::LoadU(d, at + x)), d, gap + x);
      }
    }
  }
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>

#include "server/core/features/parameters.h"

namespace treeline::features {
namespace {

HWY_EXPORT(AddGray);
HWY_EXPORT(Blur);

// Room for the widest vector.
constexpr size_t kSlack = 16;
// What sums of 16 bits hold of R + 2 G + B.
constexpr int kMaxReduction = 64;

// A Gaussian's taps from the middle on; they sum to one over both sides.
std::vector<float> Taps(float sigma) {
  const int radius =
      std::max(1, static_cast<int>(std::lround(kKernelReach * sigma)));
  std::vector<float> taps;
  float sum = 0;
  for (int k = 0; k <= radius; ++k) {
    const float t = static_cast<float>(k) / sigma;
    taps.push_back(std::exp(-0.5F * t * t));
    sum += (k == 0 ? 1.0F : 2.0F) * taps.back();
  }
  for (float& tap : taps) tap /= sum;
  return taps;
}

// What takes level l - 1 to level l; for l = 0, the picture to level 0.
const std::vector<float>& TapsOf(size_t level) {
  static const std::vector<std::vector<float>> kTaps = [] {
    std::vector<std::vector<float>> taps;
    float before = kPictureBlur_px;
    for (size_t l = 0; l < ScaleSpace::kLayers + 3; ++l) {
      const float sigma = ScaleSpace::Sigma(static_cast<float>(l));
      taps.push_back(Taps(std::sqrt(sigma * sigma - before * before)));
      before = sigma;
    }
    return taps;
  }();
  return kTaps[level];
}

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

void FloatImage::Resize(int width, int height) {
  width_ = width;
  height_ = height;
  stride_ = (static_cast<size_t>(width) + 2 * kSlack - 1) / kSlack * kSlack;
  data_.resize(stride_ * static_cast<size_t>(height) + kSlack);
}

float ScaleSpace::Sigma(float level) {
  return kBaseBlur_px * std::exp2(level / static_cast<float>(kLayers));
}

void ScaleSpace::Reduce(const image::ColorImage& image, FloatImage& reduced) {
  const int n = reduction_;
  reduced.Resize(image.width / n, image.height / n);
  const size_t pixels = static_cast<size_t>(image.width);
  row_sums_.resize(pixels);
  const auto add_gray = HWY_DYNAMIC_DISPATCH(AddGray);
  const float scale = 0.25F / static_cast<float>(n * n);
  for (int y = 0; y < reduced.height(); ++y) {
    for (int k = 0; k < n; ++k) {
      add_gray(image.rgb.data() + 3 * pixels * static_cast<size_t>(n * y + k),
               pixels, k == 0, row_sums_.data());
    }
    float* out = reduced.row(y);
    const uint16_t* in = row_sums_.data();
    for (int x = 0; x < reduced.width(); ++x, in += n) {
      uint32_t sum = 0;
      for (int k = 0; k < n; ++k) sum += in[k];
      out[x] = scale * static_cast<float>(sum);
    }
  }
}

int ScaleSpace::ReductionOf(int width, int height) {
  const double pixels = double{1} * width * height;
  return std::clamp(static_cast<int>(std::ceil(
                        std::sqrt(pixels / static_cast<double>(kMaxPixels)))),
                    1, kMaxReduction);
}

void ScaleSpace::Assign(const image::ColorImage& image, int least_reduction) {
  octave_count_ = 0;
  reduction_ = std::clamp(
      least_reduction, ReductionOf(image.width, image.height), kMaxReduction);
  int least = std::min(image.width, image.height) / reduction_;
  if (least < kMinOctaveSide_px) return;
  Reduce(image, reduced_);
  const auto blur = HWY_DYNAMIC_DISPATCH(Blur);
  for (; least >= kMinOctaveSide_px; least = (least + 1) / 2) {
    if (octave_count_ == octaves_.size()) octaves_.emplace_back();
    Octave& octave = octaves_[octave_count_];
    std::array<FloatImage, kLayers + 3>& levels = octave.gaussian;
    if (octave_count_ > 0) {
      Decimate(octaves_[octave_count_ - 1].gaussian[kLayers], levels[0]);
    }
    const FloatImage& base = octave_count_ == 0 ? reduced_ : levels[0];
    blurred_row_.resize(base.stride() + 4 * kSlack + 64);
    for (size_t l = octave_count_ == 0 ? 0 : 1; l < levels.size(); ++l) {
      const std::vector<float>& taps = TapsOf(l);
      const FloatImage& in = l == 0 ? base : levels[l - 1];
      levels[l].Resize(base.width(), base.height());
      FloatImage* difference = nullptr;
      if (l > 0) {
        difference = &octave.difference[l - 1];
        difference->Resize(base.width(), base.height());
      }
      blur(in, taps.data(), static_cast<int>(taps.size()) - 1,
           blurred_row_.data(), levels[l], difference);
    }
    ++octave_count_;
  }
}

}  // namespace treeline::features
#endif  // HWY_ONCE
