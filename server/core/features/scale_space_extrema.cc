#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/scale_space_extrema.cc"
#include "server/core/features/scale_space_extrema.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The x in [begin, end) of a row at which the middle one of the differences of
// four levels is further from zero than `least` and than all neighbours of its
// sign, in this difference (rows one stride apart), the one below and the one
// above. `levels` are the rows at the same y. Returns how many it wrote to
// found, which has room for end - begin and a vector.
size_t ExtremaOfRow(const float* const* levels, ptrdiff_t stride,
                    ptrdiff_t begin, ptrdiff_t end, float least,
                    int32_t* found) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const ptrdiff_t lanes = static_cast<ptrdiff_t>(hn::Lanes(d));
  const auto sign_bit = hn::SignBit(d);
  const auto threshold = hn::Set(d, least);
  size_t count = 0;
  for (ptrdiff_t x = begin; x < end; x += lanes) {
    const auto difference = [&](size_t l, ptrdiff_t at) HWY_ATTR {
      return hn::Sub(hn::LoadU(d, levels[l + 1] + at),
                     hn::LoadU(d, levels[l] + at));
    };
    const auto value = difference(1, x);
    // With this sign, every extremum is a maximum.
    const auto sign = hn::And(value, sign_bit);
    const auto size = hn::Abs(value);
    const auto upright = [&](size_t l, ptrdiff_t at) HWY_ATTR {
      return hn::Xor(difference(l, at), sign);
    };
    const auto of_three = [&](size_t l, ptrdiff_t at) HWY_ATTR {
      return hn::Max(hn::Max(upright(l, at - 1), upright(l, at)),
                     upright(l, at + 1));
    };
    // Of equal neighbours the last one counts, so that a value that occurs
    // twice is found once.
    auto beyond = hn::Gt(size, threshold);
    if (hn::AllFalse(d, beyond)) continue;
    beyond = hn::And(beyond, hn::And(hn::Ge(size, upright(1, x - 1)),
                                     hn::Gt(size, upright(1, x + 1))));
    if (hn::AllFalse(d, beyond)) continue;
    beyond = hn::And(beyond, hn::And(hn::Ge(size, of_three(1, x - stride)),
                                     hn::Gt(size, of_three(1, x + stride))));
    if (hn::AllFalse(d, beyond)) continue;
    const auto of_nine = [&](size_t l) HWY_ATTR {
      return hn::Max(hn::Max(of_three(l, x - stride), of_three(l, x)),
                     of_three(l, x + stride));
    };
    beyond = hn::And(
        beyond, hn::And(hn::Ge(size, of_nine(0)), hn::Gt(size, of_nine(2))));
    if (hn::AllFalse(d, beyond)) continue;
    count += hn::CompressStore(hn::Iota(di, static_cast<int32_t>(x)),
                               hn::RebindMask(di, beyond), di, found + count);
  }
  while (count > 0 && found[count - 1] >= static_cast<int32_t>(end)) --count;
  return count;
}

// The sum of |a - b| over a row.
float AbsSum(const float* a, const float* b, size_t width) {
  const hn::CappedTag<float, 16> d;
  const size_t lanes = hn::Lanes(d);
  auto sum = hn::Zero(d);
  size_t x = 0;
  for (; x + lanes <= width; x += lanes) {
    sum = hn::Add(sum,
                  hn::Abs(hn::Sub(hn::LoadU(d, a + x), hn::LoadU(d, b + x))));
  }
  float total = hn::GetLane(hn::SumOfLanes(d, sum));
  for (; x < width; ++x) {
    const float value = a[x] - b[x];
    total += value < 0 ? -value : value;
  }
  return total;
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "server/core/features/parameters.h"

namespace treeline::features {
namespace {

HWY_EXPORT(ExtremaOfRow);
HWY_EXPORT(AbsSum);

// A refined contrast is larger than that of the pixel, but not by more.
constexpr float kPixelContrast = 0.8F;

using Octave = ScaleSpace::Octave;

// First and second derivatives of the differences at a pixel, by x, y and
// level.
struct Curvature {
  float dx, dy, ds;
  float dxx, dyy, dss, dxy, dxs, dys;
};

Curvature CurvatureAt(const Octave& octave, size_t level, int x, int y) {
  const auto at = [&](int l, int i, int j) {
    const size_t above = level + static_cast<size_t>(l);
    return octave.gaussian[above].row(y + j)[x + i] -
           octave.gaussian[above - 1].row(y + j)[x + i];
  };
  // Levels are counted 0, 1, 2 from the one below.
  const float middle = at(1, 0, 0);
  Curvature c;
  c.dx = 0.5F * (at(1, 1, 0) - at(1, -1, 0));
  c.dy = 0.5F * (at(1, 0, 1) - at(1, 0, -1));
  c.ds = 0.5F * (at(2, 0, 0) - at(0, 0, 0));
  c.dxx = at(1, 1, 0) + at(1, -1, 0) - 2 * middle;
  c.dyy = at(1, 0, 1) + at(1, 0, -1) - 2 * middle;
  c.dss = at(2, 0, 0) + at(0, 0, 0) - 2 * middle;
  c.dxy = 0.25F * (at(1, 1, 1) - at(1, -1, 1) - at(1, 1, -1) + at(1, -1, -1));
  c.dxs = 0.25F * (at(2, 1, 0) - at(2, -1, 0) - at(0, 1, 0) + at(0, -1, 0));
  c.dys = 0.25F * (at(2, 0, 1) - at(2, 0, -1) - at(0, 0, 1) + at(0, 0, -1));
  return c;
}

struct Offset {
  float x, y, s;
};

// Where the parabola's gradient vanishes. nullopt: nowhere.
std::optional<Offset> ExtremumOf(const Curvature& c) {
  // Cramer's rule on the symmetric system H offset = -gradient.
  const float a = c.dyy * c.dss - c.dys * c.dys;
  const float b = c.dys * c.dxs - c.dxy * c.dss;
  const float e = c.dxy * c.dys - c.dyy * c.dxs;
  const float determinant = c.dxx * a + c.dxy * b + c.dxs * e;
  if (!(std::abs(determinant) > 0)) return std::nullopt;
  const float f = c.dxx * c.dss - c.dxs * c.dxs;
  const float g = c.dxs * c.dxy - c.dxx * c.dys;
  const float h = c.dxx * c.dyy - c.dxy * c.dxy;
  return Offset{-(a * c.dx + b * c.dy + e * c.ds) / determinant,
                -(b * c.dx + f * c.dy + g * c.ds) / determinant,
                -(e * c.dx + g * c.dy + h * c.ds) / determinant};
}

bool IsOnEdge(const Curvature& c, float ratio) {
  const float trace = c.dxx + c.dyy;
  const float determinant = c.dxx * c.dyy - c.dxy * c.dxy;
  return !(determinant > 0) ||
         trace * trace * ratio >= (ratio + 1) * (ratio + 1) * determinant;
}

// The extremum near a pixel. nullopt: it runs away, or is on an edge.
std::optional<ScaleSpaceExtremum> Refine(const Octave& octave, size_t level,
                                         int x, int y,
                                         const ExtremumOptions& options) {
  const float beyond = options.move_beyond;
  const auto step_of = [beyond](float offset) {
    return offset > beyond ? 1 : offset < -beyond ? -1 : 0;
  };
  for (int move = 0; move < kMaxMoves; ++move) {
    const Curvature c = CurvatureAt(octave, level, x, y);
    const std::optional<Offset> offset = ExtremumOf(c);
    if (!offset) return std::nullopt;
    const int step_x = step_of(offset->x);
    const int step_y = step_of(offset->y);
    const int step_s = step_of(offset->s);
    if (step_x == 0 && step_y == 0 && step_s == 0) {
      if (IsOnEdge(c, options.max_curvature_ratio)) return std::nullopt;
      const float value =
          (octave.gaussian[level + 1].row(y)[x] -
           octave.gaussian[level].row(y)[x]) +
          0.5F * (c.dx * offset->x + c.dy * offset->y + c.ds * offset->s);
      return ScaleSpaceExtremum{.x = static_cast<float>(x) + offset->x,
                                .y = static_cast<float>(y) + offset->y,
                                .level = static_cast<float>(level) + offset->s,
                                .contrast = std::abs(value)};
    }
    x += step_x;
    y += step_y;
    const int to = static_cast<int>(level) + step_s;
    if (to < 1 || to > ScaleSpace::kLayers || x < kExtremumBorder_px ||
        y < kExtremumBorder_px || x >= octave.width() - kExtremumBorder_px ||
        y >= octave.height() - kExtremumBorder_px) {
      return std::nullopt;
    }
    level = static_cast<size_t>(to);
  }
  return std::nullopt;
}

}  // namespace

float MeanDifference(const ScaleSpace& space) {
  const Octave& octave = space.octaves()[0];
  const auto abs_sum = HWY_DYNAMIC_DISPATCH(AbsSum);
  double sum = 0;
  for (int y = 0; y < octave.height(); ++y) {
    sum += static_cast<double>(abs_sum(octave.gaussian[2].row(y),
                                       octave.gaussian[1].row(y),
                                       static_cast<size_t>(octave.width())));
  }
  return static_cast<float>(sum / octave.width() / octave.height());
}

void FindExtrema(const ScaleSpace& space, size_t o,
                 const ExtremumOptions& options,
                 std::vector<ScaleSpaceExtremum>& extrema) {
  const auto extrema_of_row = HWY_DYNAMIC_DISPATCH(ExtremaOfRow);
  const Octave& octave = space.octaves()[o];
  std::vector<int32_t> found(octave.gaussian[0].stride() + FloatImage::kSlack);
  // Rows of all levels while they are in the cache.
  for (int y = kExtremumBorder_px; y < octave.height() - kExtremumBorder_px;
       ++y) {
    for (size_t level = 1; level <= ScaleSpace::kLayers; ++level) {
      const std::array<const float*, 4> rows = {
          octave.gaussian[level - 1].row(y), octave.gaussian[level].row(y),
          octave.gaussian[level + 1].row(y), octave.gaussian[level + 2].row(y)};
      const size_t count = extrema_of_row(
          rows.data(), static_cast<ptrdiff_t>(octave.gaussian[0].stride()),
          kExtremumBorder_px, octave.width() - kExtremumBorder_px,
          kPixelContrast * options.least_contrast, found.data());
      for (size_t i = 0; i < count; ++i) {
        std::optional<ScaleSpaceExtremum> extremum =
            Refine(octave, level, found[i], y, options);
        if (!extremum || extremum->contrast < options.least_contrast) continue;
        extremum->octave = o;
        extrema.push_back(*extremum);
      }
    }
  }
}

SiftKeypoint KeypointOf(const ScaleSpace& space,
                        const ScaleSpaceExtremum& extremum, float angle_rad) {
  const auto pixel = static_cast<float>(
      space.pixel() * static_cast<double>(1u << extremum.octave));
  return {.pixel = {space.InImage(extremum.x, extremum.octave),
                    space.InImage(extremum.y, extremum.octave)},
          .diameter_px = 2 * space.Sigma(extremum.level) * pixel,
          .angle_deg = angle_rad * static_cast<float>(180 / std::numbers::pi),
          .response = extremum.contrast};
}

}  // namespace treeline::features
#endif  // HWY_ONCE
