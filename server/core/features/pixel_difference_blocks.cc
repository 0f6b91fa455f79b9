#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/pixel_difference_blocks.cc"
#include "server/core/features/pixel_difference_blocks.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A vector load reads three bytes behind the pixel that is asked for.
static_assert(PlanarImage::kPadding_bytes >= 3);

void EvaluateAll(std::span<const PixelDifferenceBlock> blocks,
                 const PlanarImage& image, int32_t x, int32_t y,
                 int32_t inverse_depth_q12, int16_t* values) {
  const hn::CappedTag<int32_t, PixelDifferenceBlock::kFeatures> d;
  const hn::Rebind<int16_t, decltype(d)> d16;
  const hn::Rebind<uint8_t, decltype(d)> d8;
  const int32_t plane = image.plane_bytes();
  const uint8_t* here =
      image.data() + static_cast<ptrdiff_t>(y) * image.width() + x;
  const auto red = hn::Set(d, here[0]);
  const auto green = hn::Set(d, here[plane]);
  const auto blue = hn::Set(d, here[2 * static_cast<ptrdiff_t>(plane)]);
  const auto one = hn::Set(d, 1);
  const auto zero = hn::Zero(d);
  const auto q = hn::Set(d, inverse_depth_q12);
  const auto half = hn::Set(d, 1 << (kOffsetShift - 1));
  const auto at = [&](auto delta, int32_t from, int32_t last) {
    const auto offset =
        hn::ShiftRight<kOffsetShift>(hn::Add(hn::Mul(delta, q), half));
    return hn::Min(hn::Max(hn::Add(offset, hn::Set(d, from)), zero),
                   hn::Set(d, last));
  };
  for (const PixelDifferenceBlock& block : blocks) {
    for (size_t k = 0; k < PixelDifferenceBlock::kFeatures;
         k += hn::Lanes(d), values += hn::Lanes(d)) {
      const auto x2 = at(hn::PromoteTo(d, hn::LoadU(d16, block.dx + k)), x,
                         image.width() - 1);
      const auto y2 = at(hn::PromoteTo(d, hn::LoadU(d16, block.dy + k)), y,
                         image.height() - 1);
      const auto c1 = hn::PromoteTo(d, hn::LoadU(d8, block.c1 + k));
      const auto c2 = hn::PromoteTo(d, hn::LoadU(d8, block.c2 + k));
      const auto place =
          hn::Add(hn::Mul(c2, hn::Set(d, plane)),
                  hn::Add(hn::Mul(y2, hn::Set(d, image.width())), x2));
      const auto there =
          hn::And(hn::GatherOffset(
                      d, reinterpret_cast<const int32_t*>(image.data()), place),
                  hn::Set(d, 255));
      const auto first = hn::IfThenElse(
          hn::Eq(c1, zero), red, hn::IfThenElse(hn::Eq(c1, one), green, blue));
      hn::StoreU(hn::DemoteTo(d16, hn::Sub(first, there)), d16, values);
    }
  }
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeline::features {

HWY_EXPORT(EvaluateAll);

void EvaluateBlocks(std::span<const PixelDifferenceBlock> blocks,
                    const PlanarImage& image, int32_t x, int32_t y,
                    int32_t inverse_depth_q12, std::span<int16_t> values) {
  HWY_DYNAMIC_DISPATCH(EvaluateAll)
  (blocks, image, x, y, inverse_depth_q12, values.data());
}

}  // namespace treeline::features
#endif  // HWY_ONCE
