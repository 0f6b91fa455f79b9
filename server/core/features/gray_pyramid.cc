#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/gray_pyramid.cc"
#include "server/core/features/gray_pyramid.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// (R + 2 G + B + 2) / 4 of each pixel, rounded down.
void GrayOfPlanes(const uint8_t* red, const uint8_t* green, const uint8_t* blue,
                  size_t pixels, uint8_t* gray) {
  const hn::ScalableTag<uint8_t> d;
  const size_t lanes = hn::Lanes(d);
  const auto one = hn::Set(d, uint8_t{1});
  size_t i = 0;
  for (; i + lanes <= pixels; i += lanes) {
    const auto r = hn::LoadU(d, red + i);
    const auto b = hn::LoadU(d, blue + i);
    // (R + B) / 2, rounded down; what is lost cannot change the result.
    const auto middle =
        hn::Sub(hn::AverageRound(r, b), hn::And(hn::Xor(r, b), one));
    hn::StoreU(hn::AverageRound(middle, hn::LoadU(d, green + i)), d, gray + i);
  }
  for (; i < pixels; ++i) {
    gray[i] = static_cast<uint8_t>((red[i] + 2 * green[i] + blue[i] + 2) / 4);
  }
}

// The means of 2 x 2 pixels of two rows.
void HalveRows(const uint8_t* top, const uint8_t* bottom, size_t pixels,
               uint8_t* out) {
  size_t x = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::ScalableTag<uint16_t> d16;
  const hn::RebindToSigned<decltype(d16)> di16;
  const hn::Repartition<uint8_t, decltype(d16)> d8;
  const hn::Rebind<uint8_t, decltype(d16)> half8;
  const size_t lanes = hn::Lanes(d16);
  const auto low = hn::Set(d16, uint16_t{255});
  const auto two = hn::Set(d16, uint16_t{2});
  const auto pairs = [&](const uint8_t* row) HWY_ATTR {
    const auto both = hn::BitCast(d16, hn::LoadU(d8, row));
    return hn::Add(hn::And(both, low), hn::ShiftRight<8>(both));
  };
  for (; x + lanes <= pixels; x += lanes) {
    const auto sum =
        hn::Add(hn::Add(pairs(top + 2 * x), pairs(bottom + 2 * x)), two);
    hn::StoreU(hn::DemoteTo(half8, hn::BitCast(di16, hn::ShiftRight<2>(sum))),
               half8, out + x);
  }
#endif
  for (; x < pixels; ++x) {
    out[x] = static_cast<uint8_t>(
        (top[2 * x] + top[2 * x + 1] + bottom[2 * x] + bottom[2 * x + 1] + 2) /
        4);
  }
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeline::features {

HWY_EXPORT(GrayOfPlanes);
HWY_EXPORT(HalveRows);

void GrayPyramid::Assign(const PlanarImage& image) {
  Level& full = levels_[0];
  full.width = image.width();
  full.height = image.height();
  const size_t pixels = static_cast<size_t>(image.plane_bytes());
  full.gray.resize(pixels);
  const uint8_t* red = image.data();
  HWY_DYNAMIC_DISPATCH(GrayOfPlanes)
  (red, red + pixels, red + 2 * pixels, pixels, full.gray.data());
  const auto halve_rows = HWY_DYNAMIC_DISPATCH(HalveRows);
  for (size_t l = 1; l < kLevels; ++l) {
    const Level& below = levels_[l - 1];
    Level& level = levels_[l];
    level.width = below.width / 2;
    level.height = below.height / 2;
    level.gray.resize(static_cast<size_t>(level.width) *
                      static_cast<size_t>(level.height));
    for (int y = 0; y < level.height; ++y) {
      const uint8_t* top = below.gray.data() + 2 * y * below.width;
      halve_rows(top, top + below.width, static_cast<size_t>(level.width),
                 level.gray.data() + y * level.width);
    }
  }
}

}  // namespace treeline::features
#endif  // HWY_ONCE
