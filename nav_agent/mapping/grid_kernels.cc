#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav_agent/mapping/grid_kernels.cc"
#include "nav_agent/mapping/grid_kernels.h"

#include <algorithm>
#include <cmath>

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::mapping::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void Larger(const uint8_t* a, const uint8_t* b, uint8_t* to, size_t count) {
  const hn::ScalableTag<uint8_t> d;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::StoreU(hn::Max(hn::LoadU(d, a + i), hn::LoadU(d, b + i)), d, to + i);
  }
  for (; i < count; ++i) to[i] = std::max(a[i], b[i]);
}

// A segment that climbs by less (cells) lies along the rows.
constexpr double kLevelRow = 1e-3;

void Segment(const GridSegment& segment, uint32_t piece, float steps_per_cell2,
             int max_steps, size_t width, uint32_t* cells) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  const double length2 =
      segment.along_x * segment.along_x + segment.along_y * segment.along_y;
  const auto along_x = hn::Set(d, static_cast<float>(segment.along_x));
  const auto along_y = hn::Set(d, static_cast<float>(segment.along_y));
  const auto inverse =
      hn::Set(d, static_cast<float>(length2 > 0 ? 1 / length2 : 0));
  const auto scale = hn::Set(d, steps_per_cell2);
  const auto zero = hn::Zero(d);
  const auto one = hn::Set(d, 1.0F);
  const auto none = hn::Set(du, kNoPiece);
  const auto number = hn::Set(du, piece);
  const auto limit = hn::Set(di, max_steps);
  // Half of what a row has of the strip of cells that are near to the line.
  const bool is_steep = std::abs(segment.along_y) > kLevelRow;
  const double half_row =
      is_steep ? segment.reach * std::sqrt(length2) / std::abs(segment.along_y)
               : 0;
  for (int y = segment.bottom; y <= segment.top; ++y) {
    const double off_y = y - segment.begin_y;
    int begin = segment.left;
    int end = segment.right;
    if (is_steep) {
      const double middle =
          segment.begin_x + off_y * segment.along_x / segment.along_y;
      begin = static_cast<int>(std::max<double>(begin, middle - half_row - 1));
      end = static_cast<int>(std::min<double>(end, middle + half_row + 1));
    }
    uint32_t* row = cells + static_cast<size_t>(y) * width;
    const auto from_y = hn::Set(d, static_cast<float>(off_y));
    const auto dot_y = hn::Mul(from_y, along_y);
    for (int x = begin; x <= end; x += lanes) {
      const auto from_x = hn::Iota(d, static_cast<float>(x - segment.begin_x));
      const auto dot = hn::Add(hn::Mul(from_x, along_x), dot_y);
      const auto t = hn::Min(hn::Max(hn::Mul(dot, inverse), zero), one);
      const auto off_along_x = hn::Sub(from_x, hn::Mul(t, along_x));
      const auto off_along_y = hn::Sub(from_y, hn::Mul(t, along_y));
      const auto distance2 = hn::Add(hn::Mul(off_along_x, off_along_x),
                                     hn::Mul(off_along_y, off_along_y));
      const auto step = hn::ConvertTo(di, hn::Mul(distance2, scale));
      const auto is_near = hn::And(
          hn::Lt(step, limit), hn::Lt(hn::Iota(di, x), hn::Set(di, end + 1)));
      const auto key =
          hn::Or(hn::ShiftLeft<kPieceBits>(hn::BitCast(du, step)), number);
      const auto known = hn::LoadU(du, row + x);
      hn::StoreU(hn::Min(known, hn::IfThenElse(hn::RebindMask(du, is_near), key,
                                               none)),
                 du, row + x);
    }
  }
}

// So many bytes of 255 fit into 16 bits.
constexpr size_t kFew = 257;

void Sum(const uint8_t* corner, const int32_t* offsets, size_t count, int width,
         uint32_t* sums) {
  const hn::CappedTag<uint16_t, 8> words;
  const hn::Rebind<uint8_t, decltype(words)> bytes;
  const size_t lanes = hn::Lanes(words);
  std::fill(sums, sums + size_t{kSumWindow} * kSumRow, 0);
  uint16_t few[8];
  for (size_t y = 0; y < kSumWindow; ++y) {
    for (size_t x = 0; x < kSumRow; x += lanes) {
      const uint8_t* cells = corner + y * static_cast<size_t>(width) + x;
      uint32_t* cell_sums = sums + y * kSumRow + x;
      for (size_t begin = 0; begin < count; begin += kFew) {
        const size_t end = std::min(count, begin + kFew);
        auto sum = hn::Zero(words);
        for (size_t i = begin; i < end; ++i) {
          sum = hn::Add(
              sum, hn::PromoteTo(words, hn::LoadU(bytes, cells + offsets[i])));
        }
        hn::StoreU(sum, words, few);
        for (size_t k = 0; k < lanes; ++k) cell_sums[k] += few[k];
      }
    }
  }
}

}  // namespace treeline::mapping::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeline::mapping {

HWY_EXPORT(Larger);
HWY_EXPORT(Segment);
HWY_EXPORT(Sum);

void WriteLarger(const uint8_t* a, const uint8_t* b, uint8_t* to,
                 size_t count) {
  HWY_DYNAMIC_DISPATCH(Larger)(a, b, to, count);
}

void DrawSegment(const GridSegment& segment, uint32_t piece,
                 double steps_per_cell2, int max_steps, int width,
                 uint32_t* cells) {
  HWY_DYNAMIC_DISPATCH(Segment)
  (segment, piece, static_cast<float>(steps_per_cell2), max_steps,
   static_cast<size_t>(width), cells);
}

void SumWindows(const uint8_t* corner, std::span<const int32_t> offsets,
                int width, WindowSums& sums) {
  HWY_DYNAMIC_DISPATCH(Sum)
  (corner, offsets.data(), offsets.size(), width, sums.data());
}

}  // namespace treeline::mapping
#endif  // HWY_ONCE
