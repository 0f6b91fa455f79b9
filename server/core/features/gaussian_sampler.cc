#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/gaussian_sampler.cc"
#include "server/core/features/gaussian_sampler.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// sums[x] becomes the weighted sum of rows[k][x].
void AddRows(std::span<const uint8_t* const> rows, const float* weights,
             size_t width, float* sums) {
  const hn::CappedTag<float, 16> d;
  const hn::Rebind<int32_t, decltype(d)> d32;
  const hn::Rebind<uint8_t, decltype(d)> d8;
  size_t x = 0;
  for (; x + hn::Lanes(d) <= width; x += hn::Lanes(d)) {
    auto sum = hn::Zero(d);
    for (size_t k = 0; k < rows.size(); ++k) {
      const auto gray =
          hn::ConvertTo(d, hn::PromoteTo(d32, hn::LoadU(d8, rows[k] + x)));
      sum = hn::MulAdd(gray, hn::Set(d, weights[k]), sum);
    }
    hn::StoreU(sum, d, sums + x);
  }
  for (; x < width; ++x) {
    sums[x] = 0;
    for (size_t k = 0; k < rows.size(); ++k) {
      sums[x] += weights[k] * static_cast<float>(rows[k][x]);
    }
  }
}

// row[i] becomes the weighted sum of `taps` places from first[i] on; `taps` is
// a multiple of 8.
void AddColumns(const float* sums, std::span<const int32_t> first,
                const float* weights, size_t taps, float* row) {
  const hn::CappedTag<float, 8> d;
  for (size_t i = 0; i < first.size(); ++i, weights += taps) {
    auto sum = hn::Zero(d);
    for (size_t k = 0; k < taps; k += hn::Lanes(d)) {
      sum = hn::MulAdd(hn::LoadU(d, sums + first[i] + k),
                       hn::LoadU(d, weights + k), sum);
    }
    row[i] = hn::GetLane(hn::SumOfLanes(d, sum));
  }
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>

namespace treeline::features {
namespace {

HWY_EXPORT(AddRows);
HWY_EXPORT(AddColumns);

// What lies further out weighs less than a thousandth.
constexpr double kReach_sigmas = 3.717;
constexpr int kTapsAtOnce = 8;

}  // namespace

GaussianSampler::Taps::Taps(int size, double scale, double sigma_px)
    : radius(static_cast<int>(std::ceil(kReach_sigmas * sigma_px / scale))),
      count(static_cast<size_t>((2 * radius + kTapsAtOnce) / kTapsAtOnce *
                                kTapsAtOnce)) {
  const int places = static_cast<int>(size * scale);
  for (int i = 0; i < places; ++i) {
    const double center = (i + 0.5) / scale - 0.5;
    first.push_back(static_cast<int32_t>(std::lround(center)) - radius);
    const size_t begin = weight.size();
    weight.resize(begin + count);
    double sum = 0;
    for (int k = 0; k <= 2 * radius; ++k) {
      const double off = (first.back() + k - center) * scale / sigma_px;
      weight[begin + static_cast<size_t>(k)] =
          static_cast<float>(std::exp(-0.5 * off * off));
      sum += std::exp(-0.5 * off * off);
    }
    for (float& w : std::span(weight).subspan(begin)) {
      w /= static_cast<float>(sum);
    }
  }
}

GaussianSampler::GaussianSampler(int width, int height, double scale,
                                 double sigma_px)
    : picture_width_(width),
      picture_height_(height),
      columns_(width, scale, sigma_px),
      rows_(height, scale, sigma_px),
      tap_rows_(static_cast<size_t>(2 * rows_.radius + 1)),
      sums_(static_cast<size_t>(width) + 2 * columns_.count) {}

void GaussianSampler::Sample(const uint8_t* gray, int y, std::span<float> row) {
  const size_t place = static_cast<size_t>(y);
  for (size_t k = 0; k < tap_rows_.size(); ++k) {
    const int from = std::clamp(rows_.first[place] + static_cast<int>(k), 0,
                                picture_height_ - 1);
    tap_rows_[k] = gray + static_cast<ptrdiff_t>(from) * picture_width_;
  }
  const size_t width = static_cast<size_t>(picture_width_);
  float* const begin = sums_.data() + columns_.count;
  HWY_DYNAMIC_DISPATCH(AddRows)
  (tap_rows_, rows_.weight.data() + place * rows_.count, width, begin);
  std::fill(sums_.data(), begin, *begin);
  std::fill(begin + width, sums_.data() + sums_.size(), begin[width - 1]);
  HWY_DYNAMIC_DISPATCH(AddColumns)
  (begin, columns_.first, columns_.weight.data(), columns_.count, row.data());
}

}  // namespace treeline::features
#endif  // HWY_ONCE
