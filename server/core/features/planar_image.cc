#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/planar_image.cc"
#include "server/core/features/planar_image.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void Deinterleave(const uint8_t* rgb, size_t pixels, uint8_t* planes) {
  const hn::ScalableTag<uint8_t> d;
  const size_t lanes = hn::Lanes(d);
  uint8_t* red = planes;
  uint8_t* green = planes + pixels;
  uint8_t* blue = planes + 2 * pixels;
  size_t i = 0;
  for (; i + lanes <= pixels; i += lanes) {
    hn::Vec<decltype(d)> r, g, b;
    hn::LoadInterleaved3(d, rgb + 3 * i, r, g, b);
    hn::StoreU(r, d, red + i);
    hn::StoreU(g, d, green + i);
    hn::StoreU(b, d, blue + i);
  }
  for (; i < pixels; ++i) {
    red[i] = rgb[3 * i];
    green[i] = rgb[3 * i + 1];
    blue[i] = rgb[3 * i + 2];
  }
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeline::features {

HWY_EXPORT(Deinterleave);

void PlanarImage::Assign(const image::ColorImage& image) {
  width_ = image.width;
  height_ = image.height;
  const size_t pixels =
      static_cast<size_t>(width_) * static_cast<size_t>(height_);
  data_.resize(3 * pixels + kPadding_bytes);
  HWY_DYNAMIC_DISPATCH(Deinterleave)(image.rgb.data(), pixels, data_.data());
}

}  // namespace treeline::features
#endif  // HWY_ONCE
