#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "common/image/png_unfilter.cc"
#include "common/image/png_unfilter.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

// What all targets share.
#ifndef TREELINE_PNG_UNFILTER_BAND_
#define TREELINE_PNG_UNFILTER_BAND_

namespace treeline::image {

// Rows of a vector, a lane of 16 bits each, and rows of a band.
constexpr size_t kLanes = 8;
constexpr size_t kBandRows = 2 * kLanes;

// Sixteen rows, and the one above them.
struct Band {
  const uint8_t* rows;    // filtered, with their filters
  const uint16_t* above;  // undone
  size_t width;           // at least kBandRows
  uint16_t* values;       // undone
};

}  // namespace treeline::image

#endif  // TREELINE_PNG_UNFILTER_BAND_

HWY_BEFORE_NAMESPACE();
namespace treeline::image::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

// Without vectors there is nothing to gain.
bool UnfilterBand(const Band& /*band*/) { return false; }

#else

namespace hn = hwy::HWY_NAMESPACE;

// Bytes are undone each for itself; a pixel's two move together.
using D8 = hn::FixedTag<uint8_t, 2 * kLanes>;
using D16 = hn::FixedTag<uint16_t, kLanes>;
using V8 = hn::Vec<D8>;
using V16 = hn::Vec<D16>;

// v[i] lane j <-> v[j] lane i.
HWY_INLINE void Transpose(V16* v) {
  const D16 d;
  const hn::RepartitionToWide<D16> d32;
  const hn::RepartitionToWide<decltype(d32)> d64;
  V16 pairs[kLanes];
  for (size_t i = 0; i < kLanes; i += 2) {
    pairs[i] = hn::InterleaveLower(d, v[i], v[i + 1]);
    pairs[i + 1] = hn::InterleaveUpper(d, v[i], v[i + 1]);
  }
  V16 fours[kLanes];
  for (size_t i = 0; i < kLanes; i += 4) {
    for (size_t k = 0; k < 2; ++k) {
      const auto a = hn::BitCast(d32, pairs[i + k]);
      const auto b = hn::BitCast(d32, pairs[i + k + 2]);
      fours[i + 2 * k] = hn::BitCast(d, hn::InterleaveLower(d32, a, b));
      fours[i + 2 * k + 1] = hn::BitCast(d, hn::InterleaveUpper(d32, a, b));
    }
  }
  for (size_t k = 0; k < kLanes / 2; ++k) {
    const auto a = hn::BitCast(d64, fours[k]);
    const auto b = hn::BitCast(d64, fours[k + 4]);
    v[2 * k] = hn::BitCast(d, hn::InterleaveLower(d64, a, b));
    v[2 * k + 1] = hn::BitCast(d, hn::InterleaveUpper(d64, a, b));
  }
}

// All bits of the lanes whose row has the filter.
struct Filters {
  V8 sub, up, average, paeth;
};

HWY_INLINE Filters FiltersOf(const uint8_t* rows, size_t row_bytes) {
  const D16 d;
  const D8 d8;
  HWY_ALIGN uint16_t filter[kLanes];
  for (size_t r = 0; r < kLanes; ++r) filter[r] = rows[r * row_bytes];
  const V16 of_row = hn::Load(d, filter);
  const auto is = [&](uint16_t number) HWY_ATTR {
    return hn::BitCast(d8,
                       hn::VecFromMask(d, hn::Eq(of_row, hn::Set(d, number))));
  };
  return {is(1), is(2), is(3), is(4)};
}

// Eight rows, the lanes of their vectors from the top.
struct RowGroup {
  Filters filters;
  V8 last;      // what the last step undid
  V8 diagonal;  // what was above in the last step
};

// One pixel further in each row. `above`: what the last step undid in the row
// above the group, in the highest lane.
HWY_INLINE V8 Step(RowGroup& g, V8 filtered, V8 above_group) {
  const D8 d;
  const V8 left = g.last;
  const V8 above = hn::CombineShiftRightBytes<14>(d, left, above_group);
  const V8 diagonal = g.diagonal;
  // Paeth: of left and above that which is on the other side of the diagonal
  // pixel, if that is at least twice as far from it as the other; the diagonal
  // pixel if neither is.
  const V8 high = hn::Max(left, above);
  const V8 low = hn::Min(left, above);
  const V8 to_high = hn::SaturatedSub(high, diagonal);
  const V8 to_low = hn::SaturatedSub(diagonal, low);
  const V8 zero = hn::Zero(d);
  const auto takes_low = hn::Eq(
      hn::SaturatedSub(hn::SaturatedAdd(to_high, to_high), to_low), zero);
  const auto takes_high =
      hn::Eq(hn::SaturatedSub(hn::SaturatedAdd(to_low, to_low), to_high), zero);
  const V8 paeth = hn::IfThenElse(takes_low, low,
                                  hn::IfThenElse(takes_high, high, diagonal));
  // (left + above) / 2, rounded down.
  const V8 average =
      hn::Sub(hn::AverageRound(left, above),
              hn::And(hn::Xor(left, above), hn::Set(d, uint8_t{1})));
  const V8 others =
      hn::Or(hn::Or(hn::And(left, g.filters.sub), hn::And(above, g.filters.up)),
             hn::And(average, g.filters.average));
  g.diagonal = above;
  g.last = hn::Add(filtered, hn::Or(hn::And(paeth, g.filters.paeth), others));
  return g.last;
}

// Pixels [x, x + kLanes) of a row that has `width`, as far as there are such.
HWY_INLINE void StorePart(V16 pixels, ptrdiff_t x, size_t width,
                          uint16_t* row) {
  const D16 d;
  if (x >= 0 && static_cast<size_t>(x) + kLanes <= width) {
    hn::StoreU(pixels, d, row + x);
    return;
  }
  HWY_ALIGN uint16_t part[kLanes];
  hn::Store(pixels, d, part);
  for (ptrdiff_t i = 0; i < static_cast<ptrdiff_t>(kLanes); ++i) {
    if (x + i < 0 || x + i >= static_cast<ptrdiff_t>(width)) continue;
    row[x + i] = part[i];
  }
}

// Filtered pixels of a group for steps [step, step + kLanes), one vector a
// step: row r of the band is at pixel step - r. What lies before a row's begin
// or behind its end is of no matter.
HWY_INLINE void Load(const Band& band, size_t group, size_t step, V16* steps) {
  const D16 d;
  const size_t row_bytes = FilteredRowBytes(band.width);
  for (size_t r = 0; r < kLanes; ++r) {
    const size_t row = group * kLanes + r;
    const uint8_t* at =
        band.rows + row * row_bytes + 1 +
        2 * (static_cast<ptrdiff_t>(step) - static_cast<ptrdiff_t>(row));
    const V16 pixels = hn::BitCast(d, hn::LoadU(D8(), at));
    steps[r] = hn::Or(hn::ShiftLeft<8>(pixels), hn::ShiftRight<8>(pixels));
  }
  Transpose(steps);
}

HWY_INLINE void Store(const Band& band, size_t group, size_t step, V16* steps) {
  Transpose(steps);
  for (size_t r = 0; r < kLanes; ++r) {
    const size_t row = group * kLanes + r;
    StorePart(steps[r],
              static_cast<ptrdiff_t>(step) - static_cast<ptrdiff_t>(row),
              band.width, band.values + row * band.width);
  }
}

// The lanes whose row has begun at a step: row r begins at step r.
HWY_INLINE V8 Begun(size_t group, size_t step) {
  const D16 d;
  const V16 row = hn::Iota(d, static_cast<uint16_t>(group * kLanes));
  const V16 now = hn::Set(d, static_cast<uint16_t>(step));
  return hn::BitCast(D8(), hn::VecFromMask(d, hn::Not(hn::Gt(row, now))));
}

// False: not undone, since this machine has no vectors.
bool UnfilterBand(const Band& band) {
  const D16 d;
  const D8 d8;
  const size_t row_bytes = FilteredRowBytes(band.width);
  RowGroup upper{FiltersOf(band.rows, row_bytes), hn::Zero(d8), hn::Zero(d8)};
  RowGroup lower{FiltersOf(band.rows + kLanes * row_bytes, row_bytes),
                 hn::Zero(d8), hn::Zero(d8)};
  const size_t end = band.width + kBandRows - 1;
  for (size_t step = 0; step < end; step += kLanes) {
    V16 a[kLanes];
    V16 b[kLanes];
    Load(band, 0, step, a);
    Load(band, 1, step, b);
    const bool begins = step < kBandRows;
    for (size_t k = 0; k < kLanes; ++k) {
      const size_t x = step + k < band.width ? step + k : band.width - 1;
      const V8 between = upper.last;
      V8 u = Step(upper, hn::BitCast(d8, a[k]),
                  hn::BitCast(d8, hn::Set(d, band.above[x])));
      V8 l = Step(lower, hn::BitCast(d8, b[k]), between);
      if (begins) {
        u = upper.last = hn::And(u, Begun(0, step + k));
        l = lower.last = hn::And(l, Begun(1, step + k));
      }
      a[k] = hn::BitCast(d, u);
      b[k] = hn::BitCast(d, l);
    }
    Store(band, 0, step, a);
    Store(band, 1, step, b);
  }
  return true;
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace treeline::image::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <cstdlib>
#include <vector>

namespace treeline::image {
namespace {

HWY_EXPORT(UnfilterBand);

// The neighbour that the plane through left, above and diagonal foretells.
int Paeth(int left, int above, int diagonal) {
  const int from_left = above - diagonal;
  const int from_above = left - diagonal;
  const int to_left = std::abs(from_left);
  const int to_above = std::abs(from_above);
  const int to_diagonal = std::abs(from_left + from_above);
  int nearest = left;
  int distance = to_left;
  if (to_above < distance) {
    nearest = above;
    distance = to_above;
  }
  return to_diagonal < distance ? diagonal : nearest;
}

int Predicted(int filter, int left, int above, int diagonal) {
  switch (filter) {
    case 1:
      return left;
    case 2:
      return above;
    case 3:
      return (left + above) / 2;
    case 4:
      return Paeth(left, above, diagonal);
    default:
      return 0;
  }
}

// One row; `above` is undone.
void UnfilterRow(const uint8_t* row, const uint16_t* above, size_t width,
                 uint16_t* values) {
  const int filter = row[0];
  int left = 0;
  int diagonal = 0;
  for (size_t x = 0; x < width; ++x) {
    const int up = above[x];
    const int high =
        row[1 + 2 * x] + Predicted(filter, left >> 8, up >> 8, diagonal >> 8);
    const int low = row[2 + 2 * x] +
                    Predicted(filter, left & 255, up & 255, diagonal & 255);
    left = (high & 255) << 8 | (low & 255);
    diagonal = up;
    values[x] = static_cast<uint16_t>(left);
  }
}

}  // namespace

bool UnfilterGray16(std::span<const uint8_t> rows, size_t width, size_t height,
                    std::span<uint16_t> values) {
  constexpr int kLastFilter = 4;
  const size_t row_bytes = FilteredRowBytes(width);
  for (size_t y = 0; y < height; ++y) {
    if (rows[y * row_bytes] > kLastFilter) return false;
  }
  const auto unfilter_band = HWY_DYNAMIC_DISPATCH(UnfilterBand);
  const std::vector<uint16_t> zeros(width);
  size_t y = 0;
  while (y < height) {
    const uint8_t* row = rows.data() + y * row_bytes;
    uint16_t* out = values.data() + y * width;
    const uint16_t* above = y == 0 ? zeros.data() : out - width;
    if (width >= kBandRows && height - y >= kBandRows &&
        unfilter_band({row, above, width, out})) {
      y += kBandRows;
    } else {
      UnfilterRow(row, above, width, out);
      ++y;
    }
  }
  return true;
}

}  // namespace treeline::image
#endif  // HWY_ONCE
