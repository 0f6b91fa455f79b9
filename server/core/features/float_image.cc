#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/float_image.cc"
#include "server/core/features/float_image.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Adds the weighted sum of each pixel's channels to sums, or stores it if
// `first`.
void AddGray(const uint8_t* rgb, size_t pixels, const GrayWeights& weights,
             bool first, uint16_t* sums) {
  const hn::ScalableTag<uint16_t> d16;
  const hn::Rebind<uint8_t, decltype(d16)> d8;
  const size_t lanes = hn::Lanes(d16);
  const auto red = hn::Set(d16, weights.red);
  const auto green = hn::Set(d16, weights.green);
  const auto blue = hn::Set(d16, weights.blue);
  size_t i = 0;
  for (; i + lanes <= pixels; i += lanes) {
    hn::Vec<decltype(d8)> r, g, b;
    hn::LoadInterleaved3(d8, rgb + 3 * i, r, g, b);
    auto sum = hn::Add(hn::Add(hn::Mul(hn::PromoteTo(d16, r), red),
                               hn::Mul(hn::PromoteTo(d16, b), blue)),
                       hn::Mul(hn::PromoteTo(d16, g), green));
    if (!first) sum = hn::Add(sum, hn::LoadU(d16, sums + i));
    hn::StoreU(sum, d16, sums + i);
  }
  for (; i < pixels; ++i) {
    const int gray = weights.red * rgb[3 * i] + weights.green * rgb[3 * i + 1] +
                     weights.blue * rgb[3 * i + 2];
    sums[i] = static_cast<uint16_t>((first ? 0 : sums[i]) + gray);
  }
}

// out[x] = scale * sums[x].
void Scale(const uint16_t* sums, size_t pixels, float scale, float* out) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> d32;
  const hn::Rebind<uint16_t, decltype(d)> d16;
  const size_t lanes = hn::Lanes(d);
  size_t x = 0;
  for (; x + lanes <= pixels; x += lanes) {
    const auto sum =
        hn::ConvertTo(d, hn::PromoteTo(d32, hn::LoadU(d16, sums + x)));
    hn::StoreU(hn::Mul(sum, hn::Set(d, scale)), d, out + x);
  }
  for (; x < pixels; ++x) out[x] = scale * static_cast<float>(sums[x]);
}

// between[x] becomes 3/4 of near[x] and 1/4 of far[x]; one place further out on
// either side is as the outermost.
void MixRows(const float* near, const float* far, int width, float* between) {
  const hn::CappedTag<float, 8> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < width; x += lanes) {
    hn::StoreU(hn::MulAdd(hn::LoadU(d, near + x), hn::Set(d, 0.75F),
                          hn::Mul(hn::LoadU(d, far + x), hn::Set(d, 0.25F))),
               d, between + x);
  }
  between[-1] = between[0];
  between[width] = between[width - 1];
}

// In every place the value a quarter of a pixel before it.
void ShiftRow(const float* near, const float* far, int width, float* between,
              float* out) {
  const hn::CappedTag<float, 8> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  MixRows(near, far, width, between);
  for (int x = 0; x < width; x += lanes) {
    const auto here = hn::Mul(hn::LoadU(d, between + x), hn::Set(d, 0.75F));
    hn::StoreU(
        hn::MulAdd(hn::LoadU(d, between + x - 1), hn::Set(d, 0.25F), here), d,
        out + x);
  }
}

// In every place two values, a quarter of a pixel before it and behind it.
void DoubleRow(const float* near, const float* far, int width, float* between,
               float* out) {
  const hn::CappedTag<float, 8> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto most = hn::Set(d, 0.75F);
  const auto rest = hn::Set(d, 0.25F);
  MixRows(near, far, width, between);
  for (int x = 0; x < width; x += lanes) {
    const auto here = hn::Mul(hn::LoadU(d, between + x), most);
    hn::StoreInterleaved2(hn::MulAdd(hn::LoadU(d, between + x - 1), rest, here),
                          hn::MulAdd(hn::LoadU(d, between + x + 1), rest, here),
                          d, out + 2 * x);
  }
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

namespace treeline::features {
namespace {

HWY_EXPORT(AddGray);
HWY_EXPORT(Scale);
HWY_EXPORT(ShiftRow);
HWY_EXPORT(DoubleRow);

}  // namespace

void FloatImage::Resize(int width, int height) {
  width_ = width;
  height_ = height;
  stride_ = (static_cast<size_t>(width) + 2 * kSlack - 1) / kSlack * kSlack;
  data_.resize(stride_ * static_cast<size_t>(height) + kSlack);
}

void ReduceToGray(const image::ColorImage& image, int n,
                  const GrayWeights& weights, std::vector<uint16_t>& row_sums,
                  FloatImage& gray) {
  gray.Resize(image.width / n, image.height / n);
  const size_t pixels = static_cast<size_t>(image.width);
  row_sums.resize(pixels);
  const auto add_gray = HWY_DYNAMIC_DISPATCH(AddGray);
  const auto scale_row = HWY_DYNAMIC_DISPATCH(Scale);
  const float scale = 1.0F / static_cast<float>(weights.sum() * n * n);
  for (int y = 0; y < gray.height(); ++y) {
    for (int k = 0; k < n; ++k) {
      add_gray(image.rgb.data() + 3 * pixels * static_cast<size_t>(n * y + k),
               pixels, weights, k == 0, row_sums.data());
    }
    float* out = gray.row(y);
    const uint16_t* in = row_sums.data();
    if (n == 1) {
      scale_row(in, pixels, scale, out);
      continue;
    }
    for (int x = 0; x < gray.width(); ++x, in += n) {
      uint32_t sum = 0;
      for (int k = 0; k < n; ++k) sum += in[k];
      out[x] = scale * static_cast<float>(sum);
    }
  }
}

void DoubleInSize(const FloatImage& in, FloatImage& doubled) {
  doubled.Resize(2 * in.width(), 2 * in.height());
  std::vector<float> between(in.stride() + 2 * FloatImage::kSlack);
  const auto double_row = HWY_DYNAMIC_DISPATCH(DoubleRow);
  const int last = in.height() - 1;
  for (int y = 0; y < doubled.height(); ++y) {
    const int near = y / 2;
    const int far = std::clamp(y % 2 == 0 ? near - 1 : near + 1, 0, last);
    // A whole vector may be written behind the end: two of 8 floats less one
    // place are fewer than kSlack.
    double_row(in.row(near), in.row(far), in.width(),
               between.data() + FloatImage::kSlack, doubled.row(y));
  }
}

void ShiftByQuarter(const FloatImage& in, FloatImage& shifted) {
  shifted.Resize(in.width(), in.height());
  std::vector<float> between(in.stride() + 2 * FloatImage::kSlack);
  const auto shift_row = HWY_DYNAMIC_DISPATCH(ShiftRow);
  for (int y = 0; y < in.height(); ++y) {
    shift_row(in.row(y), in.row(std::max(0, y - 1)), in.width(),
              between.data() + FloatImage::kSlack, shifted.row(y));
  }
}

}  // namespace treeline::features
#endif  // HWY_ONCE
