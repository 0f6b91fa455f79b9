#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/gaussian_blur.cc"
#include "server/core/features/gaussian_blur.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Convolves row y with the symmetric kernel of which taps[k] stands k from the
// middle, along both axes. `row` has room for a row, `radius` and a vector on
// either side.
void BlurRow(const FloatImage& in, int y, const float* taps, int radius,
             float* row, float* out) {
  const hn::CappedTag<float, 16> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int width = in.width();
  const int last = in.height() - 1;
  float* const middle = row + radius + lanes;
  const float* const at = in.row(y);
  for (int x = 0; x < width; x += lanes) {
    auto sum = hn::Mul(hn::LoadU(d, at + x), hn::Set(d, taps[0]));
    for (int k = 1; k <= radius; ++k) {
      const float* above = in.row(y - k < 0 ? 0 : y - k);
      const float* below = in.row(y + k > last ? last : y + k);
      sum =
          hn::MulAdd(hn::Add(hn::LoadU(d, above + x), hn::LoadU(d, below + x)),
                     hn::Set(d, taps[k]), sum);
    }
    hn::StoreU(sum, d, middle + x);
  }
  for (int k = 1; k <= radius; ++k) {
    middle[-k] = middle[0];
    middle[width - 1 + k] = middle[width - 1];
  }
  for (int x = 0; x < width; x += lanes) {
    auto sum = hn::Mul(hn::LoadU(d, middle + x), hn::Set(d, taps[0]));
    for (int k = 1; k <= radius; ++k) {
      sum = hn::MulAdd(
          hn::Add(hn::LoadU(d, middle + x - k), hn::LoadU(d, middle + x + k)),
          hn::Set(d, taps[k]), sum);
    }
    hn::StoreU(sum, d, out + x);
  }
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>

namespace treeline::features {
namespace {

HWY_EXPORT(BlurRow);

}  // namespace

GaussianBlur::GaussianBlur(float sigma_px, float reach) {
  const int radius =
      std::max(1, static_cast<int>(std::lround(reach * sigma_px)));
  float sum = 0;
  for (int k = 0; k <= radius; ++k) {
    const float t = static_cast<float>(k) / sigma_px;
    taps_.push_back(std::exp(-0.5F * t * t));
    sum += (k == 0 ? 1.0F : 2.0F) * taps_.back();
  }
  for (float& tap : taps_) tap /= sum;
}

void GaussianBlur::Rows(const FloatImage& in, int begin, int end,
                        FloatImage& out, std::vector<float>& row) const {
  const auto blur_row = HWY_DYNAMIC_DISPATCH(BlurRow);
  row.resize(in.stride() + 2 * (taps_.size() + FloatImage::kSlack));
  for (int y = begin; y < end; ++y) {
    blur_row(in, y, taps_.data(), radius(), row.data(), out.row(y));
  }
}

}  // namespace treeline::features
#endif  // HWY_ONCE
