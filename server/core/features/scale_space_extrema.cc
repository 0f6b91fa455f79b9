#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/scale_space_extrema.cc"
#include "server/core/features/scale_space_extrema.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The x in [begin, end) of a row at which `at` is further from zero than
// `least` and than all neighbours of its sign, in this level (rows one stride
// apart), the one below and the one above. Returns how many it wrote to found,
// which has room for end - begin and a vector.
size_t ExtremaOfRow(const float* below, const float* at, const float* above,
                    size_t stride, size_t begin, size_t end, float least,
                    int32_t* found) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const size_t lanes = hn::Lanes(d);
  const auto sign_bit = hn::SignBit(d);
  const auto threshold = hn::Set(d, least);
  size_t count = 0;
  for (size_t x = begin; x < end; x += lanes) {
    const auto value = hn::LoadU(d, at + x);
    // With this sign, every extremum is a maximum.
    const auto sign = hn::And(value, sign_bit);
    const auto size = hn::Abs(value);
    const auto upright = [&](const float* from) HWY_ATTR {
      return hn::Xor(hn::LoadU(d, from), sign);
    };
    const auto of_three = [&](const float* from) HWY_ATTR {
      return hn::Max(hn::Max(upright(from - 1), upright(from)),
                     upright(from + 1));
    };
    // Of equal neighbours the last one counts, so that a value that occurs
    // twice is found once.
    auto beyond = hn::And(hn::Gt(size, threshold),
                          hn::And(hn::Ge(size, upright(at + x - 1)),
                                  hn::Gt(size, upright(at + x + 1))));
    if (hn::AllFalse(d, beyond)) continue;
    beyond = hn::And(beyond, hn::And(hn::Ge(size, of_three(at + x - stride)),
                                     hn::Gt(size, of_three(at + x + stride))));
    if (hn::AllFalse(d, beyond)) continue;
    const auto of_nine = [&](const float* from) HWY_ATTR {
      return hn::Max(hn::Max(of_three(from - stride), of_three(from)),
                     of_three(from + stride));
    };
    beyond = hn::And(beyond, hn::And(hn::Ge(size, of_nine(below + x)),
                                     hn::Gt(size, of_nine(above + x))));
    if (hn::AllFalse(d, beyond)) continue;
    count += hn::CompressStore(hn::Iota(di, static_cast<int32_t>(x)),
                               hn::RebindMask(di, beyond), di, found + count);
  }
  while (count > 0 && found[count - 1] >= static_cast<int32_t>(end)) --count;
  return count;
}

// The sum of |value| over a row.
float AbsSum(const float* row, size_t width) {
  const hn::CappedTag<float, 16> d;
  const size_t lanes = hn::Lanes(d);
  auto sum = hn::Zero(d);
  size_t x = 0;
  for (; x + lanes <= width; x += lanes) {
    sum = hn::Add(sum, hn::Abs(hn::LoadU(d, row + x)));
  }
  float total = hn::GetLane(hn::SumOfLanes(d, sum));
  for (; x < width; ++x) total += row[x] < 0 ? -row[x] : row[x];
  return total;
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>
#include <optional>

#include "server/core/features/parameters.h"

namespace treeline::features {
namespace {

HWY_EXPORT(ExtremaOfRow);
HWY_EXPORT(AbsSum);

// Room for the widest vector.
constexpr size_t kSlack = 16;

using Octave = ScaleSpace::Octave;

// First and second derivatives of the differences at a pixel, by x, y and
// level.
struct Curvature {
  float dx, dy, ds;
  float dxx, dyy, dss, dxy, dxs, dys;
};

Curvature CurvatureAt(const Octave& octave, size_t level, int x, int y) {
  const auto at = [&](int l, int i, int j) {
    return octave.difference[level + static_cast<size_t>(l) - 1].row(y +
                                                                     j)[x + i];
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

bool IsOnEdge(const Curvature& c) {
  const float trace = c.dxx + c.dyy;
  const float determinant = c.dxx * c.dyy - c.dxy * c.dxy;
  const float ratio = kMaxCurvatureRatio;
  return !(determinant > 0) ||
         trace * trace * ratio >= (ratio + 1) * (ratio + 1) * determinant;
}

int StepOf(float offset) {
  return offset > kMoveBeyond_px ? 1 : offset < -kMoveBeyond_px ? -1 : 0;
}

// The extremum near a pixel. nullopt: it runs away, or is on an edge.
std::optional<ScaleSpaceExtremum> Refine(const Octave& octave, size_t level,
                                         int x, int y) {
  const FloatImage& image = octave.difference[0];
  for (int move = 0; move < kMaxMoves; ++move) {
    const Curvature c = CurvatureAt(octave, level, x, y);
    const std::optional<Offset> offset = ExtremumOf(c);
    if (!offset) return std::nullopt;
    const int step_x = StepOf(offset->x);
    const int step_y = StepOf(offset->y);
    const int step_s = StepOf(offset->s);
    if (step_x == 0 && step_y == 0 && step_s == 0) {
      if (IsOnEdge(c)) return std::nullopt;
      const float value =
          octave.difference[level].row(y)[x] +
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
        y < kExtremumBorder_px || x >= image.width() - kExtremumBorder_px ||
        y >= image.height() - kExtremumBorder_px) {
      return std::nullopt;
    }
    level = static_cast<size_t>(to);
  }
  return std::nullopt;
}

// Mean size of the finest differences.
float MeanDifference(const Octave& octave) {
  const FloatImage& finest = octave.difference[1];
  const auto abs_sum = HWY_DYNAMIC_DISPATCH(AbsSum);
  double sum = 0;
  for (int y = 0; y < finest.height(); ++y) {
    sum += static_cast<double>(
        abs_sum(finest.row(y), static_cast<size_t>(finest.width())));
  }
  return static_cast<float>(sum / finest.width() / finest.height());
}

}  // namespace

void FindExtrema(const ScaleSpace& space,
                 std::vector<ScaleSpaceExtremum>& extrema) {
  extrema.clear();
  if (space.octaves().empty()) return;
  const float least = std::max<float>(
      kMinContrast, kRelativeContrast * MeanDifference(space.octaves()[0]));
  const auto extrema_of_row = HWY_DYNAMIC_DISPATCH(ExtremaOfRow);
  std::vector<int32_t> found;
  for (size_t o = 0; o < space.octaves().size(); ++o) {
    const Octave& octave = space.octaves()[o];
    const FloatImage& size = octave.difference[0];
    found.resize(static_cast<size_t>(size.width()) + 2 * kSlack);
    for (size_t level = 1; level <= ScaleSpace::kLayers; ++level) {
      for (int y = kExtremumBorder_px; y < size.height() - kExtremumBorder_px;
           ++y) {
        const size_t count = extrema_of_row(
            octave.difference[level - 1].row(y),
            octave.difference[level].row(y),
            octave.difference[level + 1].row(y), size.stride(),
            kExtremumBorder_px,
            static_cast<size_t>(size.width() - kExtremumBorder_px),
            0.8F * least, found.data());
        for (size_t i = 0; i < count; ++i) {
          std::optional<ScaleSpaceExtremum> extremum =
              Refine(octave, level, found[i], y);
          if (!extremum || extremum->contrast < least) continue;
          extremum->octave = o;
          extrema.push_back(*extremum);
        }
      }
    }
  }
}

}  // namespace treeline::features
#endif  // HWY_ONCE
