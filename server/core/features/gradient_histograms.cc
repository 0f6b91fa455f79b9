#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/features/gradient_histograms.cc"
#include "server/core/features/gradient_histograms.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

// What all targets share.
#ifndef TREELINE_GRADIENT_HISTOGRAMS_TABLES_
#define TREELINE_GRADIENT_HISTOGRAMS_TABLES_

namespace treeline::features {

// Fourier coefficients of a histogram of directions, beside the mean.
constexpr size_t kHarmonics = 6;
using Harmonics = std::array<float, 1 + 2 * kHarmonics>;

// Weights of a square window about a pixel: a row's, and the same of columns.
struct Window {
  static constexpr int kMaxRadius = 24;
  int radius = 0;
  std::array<float, 2 * kMaxRadius + 1 + 16> weight{};  // then zeros
};

// The pixels of a window about (x, y) at which gradients can be computed:
// columns [first, end) and rows [top, bottom), and where the window itself
// begins.
struct InnerWindow {
  InnerWindow(const Window& window, int x, int y, int width, int height)
      : left(x - window.radius), above(y - window.radius) {
    first = left < 1 ? 1 : left;
    top = above < 1 ? 1 : above;
    end = x + window.radius + 1;
    if (end > width - 1) end = width - 1;
    bottom = y + window.radius + 1;
    if (bottom > height - 1) bottom = height - 1;
  }

  int left;
  int above;
  int first;
  int end;
  int top;
  int bottom;
};

// Directions of a histogram that angles are read off.
constexpr size_t kAngles = 36;

// The patch of a descriptor: kSide x kSide gradients, of samples that reach one
// further on each side.
constexpr size_t kSide = 16;
constexpr size_t kSamplesSide = kSide + 2;
constexpr size_t kSamples = kSamplesSide * kSamplesSide;
constexpr size_t kCells = 4;
constexpr size_t kDirections = 8;

struct PatchTables {
  // Sample i lies here, in steps of the grid from the middle; then zeros, up to
  // whole vectors.
  std::array<float, kSamples + 16> x{};
  std::array<float, kSamples + 16> y{};
  // Gaussian of a row or column of gradients.
  std::array<float, kSide> window{};
  // Share of a row or column in a cell.
  std::array<std::array<float, kSide>, kCells> share{};
};

}  // namespace treeline::features

#endif  // TREELINE_GRADIENT_HISTOGRAMS_TABLES_

HWY_BEFORE_NAMESPACE();
namespace treeline::features::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Sums of weight * gradient size * exp(i k direction) over the window about
// (x, y), as far as gradients can be computed there.
void SumHarmonics(const float* image, size_t stride, int width, int height,
                  int x, int y, const Window& window, Harmonics& harmonics) {
  const hn::CappedTag<float, 16> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  hn::Vec<decltype(d)> mean = hn::Zero(d);
  hn::Vec<decltype(d)> real[kHarmonics];
  hn::Vec<decltype(d)> imaginary[kHarmonics];
  for (size_t k = 0; k < kHarmonics; ++k) {
    real[k] = imaginary[k] = hn::Zero(d);
  }
  const InnerWindow inner(window, x, y, width, height);
  const int end = inner.end;
  const auto tiny = hn::Set(d, 1e-12F);
  for (int j = inner.top; j < inner.bottom; ++j) {
    const float* row = image + static_cast<size_t>(j) * stride;
    const auto row_weight =
        hn::Set(d, window.weight[static_cast<size_t>(j - inner.above)]);
    for (int i = inner.first; i < end; i += lanes) {
      const auto inside = hn::FirstN(d, static_cast<size_t>(end - i));
      const auto weight = hn::IfThenElseZero(
          inside, hn::Mul(row_weight, hn::LoadU(d, window.weight.data() +
                                                       (i - inner.left))));
      const auto gx =
          hn::Sub(hn::LoadU(d, row + i + 1), hn::LoadU(d, row + i - 1));
      const auto gy = hn::Sub(hn::LoadU(d, row + i + stride),
                              hn::LoadU(d, row + i - stride));
      const auto size = hn::Sqrt(hn::MulAdd(gx, gx, hn::MulAdd(gy, gy, tiny)));
      const auto inverse = hn::Div(hn::Set(d, 1.0F), size);
      const auto cosine = hn::Mul(gx, inverse);
      const auto sine = hn::Mul(gy, inverse);
      mean = hn::MulAdd(weight, size, mean);
      auto re = hn::Mul(weight, gx);
      auto im = hn::Mul(weight, gy);
      real[0] = hn::Add(real[0], re);
      imaginary[0] = hn::Add(imaginary[0], im);
      for (size_t k = 1; k < kHarmonics; ++k) {
        const auto turned = hn::NegMulAdd(im, sine, hn::Mul(re, cosine));
        im = hn::MulAdd(re, sine, hn::Mul(im, cosine));
        re = turned;
        real[k] = hn::Add(real[k], re);
        imaginary[k] = hn::Add(imaginary[k], im);
      }
    }
  }
  harmonics[0] = hn::GetLane(hn::SumOfLanes(d, mean));
  for (size_t k = 0; k < kHarmonics; ++k) {
    harmonics[1 + 2 * k] = hn::GetLane(hn::SumOfLanes(d, real[k]));
    harmonics[2 + 2 * k] = hn::GetLane(hn::SumOfLanes(d, imaginary[k]));
  }
}

// The direction of (x, y) in eighths of a turn, in [0, 8], exact to 1e-4.
template <class D, class V>
V DirectionOf(D d, V x, V y) {
  const V ax = hn::Abs(x);
  const V ay = hn::Abs(y);
  const V ratio =
      hn::Div(hn::Min(ax, ay), hn::Max(hn::Max(ax, ay), hn::Set(d, 1e-12F)));
  // Arctangent, Abramowitz and Stegun 4.4.49, times 4 / pi.
  const V square = hn::Mul(ratio, ratio);
  V t = hn::MulAdd(square, hn::Set(d, 0.0265281F), hn::Set(d, -0.1083948F));
  t = hn::MulAdd(square, t, hn::Set(d, 0.2293629F));
  t = hn::MulAdd(square, t, hn::Set(d, -0.4205504F));
  t = hn::MulAdd(square, t, hn::Set(d, 1.2730690F));
  t = hn::Mul(t, ratio);
  t = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(hn::Set(d, 2.0F), t), t);
  t = hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(hn::Set(d, 4.0F), t), t);
  return hn::IfThenElse(hn::Lt(y, hn::Zero(d)), hn::Sub(hn::Set(d, 8.0F), t),
                        t);
}

// Adds weight * gradient size to the nearest of kAngles directions, over the
// window about (x, y), as far as gradients can be computed there.
void SumDirections(const float* image, size_t stride, int width, int height,
                   int x, int y, const Window& window, float* histogram) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const InnerWindow inner(window, x, y, width, height);
  const int end = inner.end;
  const auto per_eighth = hn::Set(d, static_cast<float>(kAngles) / 8);
  // A full turn is direction 0 again.
  float sums[kAngles + 1] = {};
  HWY_ALIGN float share[16];
  HWY_ALIGN int32_t nearest[16];
  for (int j = inner.top; j < inner.bottom; ++j) {
    const float* row = image + static_cast<size_t>(j) * stride;
    const auto row_weight =
        hn::Set(d, window.weight[static_cast<size_t>(j - inner.above)]);
    for (int i = inner.first; i < end; i += lanes) {
      const auto gx =
          hn::Sub(hn::LoadU(d, row + i + 1), hn::LoadU(d, row + i - 1));
      const auto gy = hn::Sub(hn::LoadU(d, row + i + stride),
                              hn::LoadU(d, row + i - stride));
      const auto size = hn::Sqrt(hn::MulAdd(gx, gx, hn::Mul(gy, gy)));
      const auto weight = hn::Mul(
          row_weight, hn::LoadU(d, window.weight.data() + (i - inner.left)));
      hn::Store(hn::Mul(weight, size), d, share);
      hn::Store(hn::NearestInt(hn::Mul(DirectionOf(d, gx, gy), per_eighth)), di,
                nearest);
      const int count = end - i < lanes ? end - i : lanes;
      for (int k = 0; k < count; ++k) sums[nearest[k]] += share[k];
    }
  }
  sums[0] += sums[kAngles];
  for (size_t a = 0; a < kAngles; ++a) histogram[a] = sums[a];
}

// The image at the samples of a patch, bilinear.
void SamplePatch(const float* image, size_t stride, int width, int height,
                 float x, float y, float along_x, float along_y,
                 const PatchTables& tables, float* patch) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const auto zero = hn::Zero(d);
  const auto max_x = hn::Set(d, static_cast<float>(width) - 1.001F);
  const auto max_y = hn::Set(d, static_cast<float>(height) - 1.001F);
  const auto step_x = hn::Set(d, along_x);
  const auto step_y = hn::Set(d, along_y);
  const auto rows = hn::Set(di, static_cast<int32_t>(stride));
  for (size_t i = 0; i < kSamples; i += hn::Lanes(d)) {
    const auto u = hn::LoadU(d, tables.x.data() + i);
    const auto v = hn::LoadU(d, tables.y.data() + i);
    auto px = hn::NegMulAdd(v, step_y, hn::MulAdd(u, step_x, hn::Set(d, x)));
    auto py = hn::MulAdd(v, step_x, hn::MulAdd(u, step_y, hn::Set(d, y)));
    px = hn::Min(hn::Max(px, zero), max_x);
    py = hn::Min(hn::Max(py, zero), max_y);
    const auto column = hn::ConvertTo(di, px);
    const auto row = hn::ConvertTo(di, py);
    const auto a = hn::Sub(px, hn::ConvertTo(d, column));
    const auto b = hn::Sub(py, hn::ConvertTo(d, row));
    const auto at = hn::Add(hn::Mul(row, rows), column);
    const auto p00 = hn::GatherIndex(d, image, at);
    const auto p10 = hn::GatherIndex(d, image + 1, at);
    const auto p01 = hn::GatherIndex(d, image + stride, at);
    const auto p11 = hn::GatherIndex(d, image + stride + 1, at);
    const auto top = hn::MulAdd(a, hn::Sub(p10, p00), p00);
    const auto bottom = hn::MulAdd(a, hn::Sub(p11, p01), p01);
    hn::StoreU(hn::MulAdd(b, hn::Sub(bottom, top), top), d, patch + i);
  }
}

// histogram[(cell row * kCells + cell column) * kDirections + direction].
void FillHistogram(const float* patch, const PatchTables& tables,
                   float* histogram) {
  const hn::CappedTag<float, 16> d;
  const size_t lanes = hn::Lanes(d);
  // Not yet gathered into columns of cells.
  HWY_ALIGN float rows[kCells * kDirections * kSide] = {};
  const auto one = hn::Set(d, 1.0F);
  const auto zero = hn::Zero(d);
  for (size_t j = 0; j < kSide; ++j) {
    for (size_t i = 0; i < kSide; i += lanes) {
      const float* at = patch + (j + 1) * kSamplesSide + i + 1;
      const auto gx = hn::Sub(hn::LoadU(d, at + 1), hn::LoadU(d, at - 1));
      const auto gy = hn::Sub(hn::LoadU(d, at + kSamplesSide),
                              hn::LoadU(d, at - kSamplesSide));
      const auto size = hn::Mul(hn::Mul(hn::LoadU(d, tables.window.data() + i),
                                        hn::Set(d, tables.window[j])),
                                hn::Sqrt(hn::MulAdd(gx, gx, hn::Mul(gy, gy))));
      const auto direction = DirectionOf(d, gx, gy);
      for (size_t o = 0; o < kDirections; ++o) {
        auto gap =
            hn::Abs(hn::Sub(direction, hn::Set(d, static_cast<float>(o))));
        if (o == 0) gap = hn::Min(gap, hn::Sub(hn::Set(d, 8.0F), direction));
        const auto share = hn::Mul(size, hn::Max(zero, hn::Sub(one, gap)));
        for (size_t c = 0; c < kCells; ++c) {
          const float in_cell = tables.share[c][j];
          if (in_cell == 0) continue;
          float* sum = rows + (c * kDirections + o) * kSide + i;
          hn::Store(hn::MulAdd(share, hn::Set(d, in_cell), hn::Load(d, sum)), d,
                    sum);
        }
      }
    }
  }
  for (size_t c = 0; c < kCells; ++c) {
    for (size_t o = 0; o < kDirections; ++o) {
      const float* sums = rows + (c * kDirections + o) * kSide;
      for (size_t column = 0; column < kCells; ++column) {
        auto total = zero;
        for (size_t i = 0; i < kSide; i += lanes) {
          total =
              hn::MulAdd(hn::Load(d, sums + i),
                         hn::LoadU(d, tables.share[column].data() + i), total);
        }
        histogram[(c * kCells + column) * kDirections + o] =
            hn::GetLane(hn::SumOfLanes(d, total));
      }
    }
  }
}

// RootSIFT of a histogram that is first normalised, and cut off at `most`.
void QuantizeHistogram(const float* histogram, float most, float scale,
                       uint8_t* values) {
  constexpr size_t kSize = kCells * kCells * kDirections;
  const hn::CappedTag<float, 16> d;
  const hn::Rebind<uint8_t, decltype(d)> d8;
  const size_t lanes = hn::Lanes(d);
  auto squares = hn::Zero(d);
  for (size_t i = 0; i < kSize; i += lanes) {
    const auto h = hn::LoadU(d, histogram + i);
    squares = hn::MulAdd(h, h, squares);
  }
  const auto limit =
      hn::Mul(hn::Set(d, most), hn::Sqrt(hn::SumOfLanes(d, squares)));
  auto sum = hn::Zero(d);
  for (size_t i = 0; i < kSize; i += lanes) {
    sum = hn::Add(sum, hn::Min(limit, hn::LoadU(d, histogram + i)));
  }
  const auto gain =
      hn::Div(hn::Set(d, scale * scale),
              hn::Max(hn::SumOfLanes(d, sum), hn::Set(d, 1e-12F)));
  for (size_t i = 0; i < kSize; i += lanes) {
    const auto h = hn::Min(limit, hn::LoadU(d, histogram + i));
    hn::StoreU(hn::DemoteTo(d8, hn::NearestInt(hn::Sqrt(hn::Mul(h, gain)))), d8,
               values + i);
  }
}

}  // namespace treeline::features::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/core/features/parameters.h"
#include "server/core/features/scale_space.h"

namespace treeline::features {
namespace {

HWY_EXPORT(SumHarmonics);
HWY_EXPORT(SumDirections);
HWY_EXPORT(SamplePatch);
HWY_EXPORT(FillHistogram);
HWY_EXPORT(QuantizeHistogram);

// Lowe's window in which angles are sought: its standard deviation in blurs of
// the feature, and its radius in standard deviations.
constexpr float kLoweAngleWindow = 1.5F;
constexpr float kLoweAngleWindowReach = 3;
// Angles of one of FastSift's places.
constexpr size_t kFastAngles = 2;

// A Gaussian cut off at `reach` standard deviations.
Window MakeWindow(float sigma_px, float reach) {
  Window window;
  window.radius = std::min(Window::kMaxRadius,
                           static_cast<int>(std::lround(reach * sigma_px)));
  for (int i = -window.radius; i <= window.radius; ++i) {
    const float t = static_cast<float>(i) / sigma_px;
    window.weight[static_cast<size_t>(i + window.radius)] =
        std::exp(-0.5F * t * t);
  }
  return window;
}

// Windows of features of layers 1 to kLayers of FastSift's scale space.
const Window& WindowOf(float sigma) {
  static const std::array<Window, ScaleSpace::kLayers> kWindows = [] {
    std::array<Window, ScaleSpace::kLayers> windows;
    for (size_t l = 0; l < windows.size(); ++l) {
      windows[l] = MakeWindow(
          kAngleWindow *
              ScaleSpace::BlurOfLevel(kBaseBlur_px, static_cast<float>(l + 1)),
          kAngleWindowReach);
    }
    return windows;
  }();
  const double layer = ScaleSpace::kLayers *
                       std::log2(static_cast<double>(sigma) / kBaseBlur_px);
  return kWindows[static_cast<size_t>(
      std::clamp<long>(std::lround(layer), 1, ScaleSpace::kLayers) - 1)];
}

struct AngleTables {
  // Of direction a and harmonic k.
  std::array<std::array<float, kAngles>, kHarmonics> cosine;
  std::array<std::array<float, kAngles>, kHarmonics> sine;
};

const AngleTables& Angles() {
  static const AngleTables kTables = [] {
    AngleTables tables;
    for (size_t k = 0; k < kHarmonics; ++k) {
      const double order = static_cast<double>(k + 1);
      // The Fourier transform of a Gaussian that smooths.
      const double smooth =
          2 * std::exp(-0.5 * order * order * kAngleSmoothing_rad *
                       kAngleSmoothing_rad);
      for (size_t a = 0; a < kAngles; ++a) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(a) *
                             order / static_cast<double>(kAngles);
        tables.cosine[k][a] = static_cast<float>(smooth * std::cos(angle));
        tables.sine[k][a] = static_cast<float>(smooth * std::sin(angle));
      }
    }
    return tables;
  }();
  return kTables;
}

const PatchTables& Patch() {
  static const PatchTables kTables = [] {
    PatchTables tables;
    const float middle = 0.5F * static_cast<float>(kSamplesSide - 1);
    for (size_t i = 0; i < kSamples; ++i) {
      tables.x[i] = static_cast<float>(i % kSamplesSide) - middle;
      tables.y[i] = static_cast<float>(i / kSamplesSide) - middle;
    }
    for (size_t i = 0; i < kSide; ++i) {
      // In cells from the middle of the patch.
      const float at =
          (static_cast<float>(i) + 0.5F - 0.5F * static_cast<float>(kSide)) *
          kPatchCells / static_cast<float>(kSide);
      tables.window[i] =
          std::exp(-0.5F * at * at / (kPatchWindow * kPatchWindow));
      for (size_t c = 0; c < kCells; ++c) {
        const float cell =
            static_cast<float>(c) + 0.5F - 0.5F * static_cast<float>(kCells);
        tables.share[c][i] = std::max(0.0F, 1 - std::abs(at - cell));
      }
    }
    return tables;
  }();
  return kTables;
}

// Peaks of a histogram of directions, `most` at most.
DominantAngles PeaksOf(const std::array<float, kAngles>& histogram,
                       size_t most) {
  DominantAngles found;
  const float least =
      kSecondAngle * *std::max_element(histogram.begin(), histogram.end());
  std::array<float, DominantAngles::kMax> height{};
  for (size_t a = 0; a < kAngles; ++a) {
    const float before = histogram[(a + kAngles - 1) % kAngles];
    const float here = histogram[a];
    const float after = histogram[(a + 1) % kAngles];
    if (here < least || !(here > before && here >= after)) continue;
    const float at = static_cast<float>(a) +
                     0.5F * (before - after) / (before - 2 * here + after);
    const float turn = static_cast<float>(2 * std::numbers::pi);
    float angle = at * turn / static_cast<float>(kAngles);
    if (angle < 0) angle += turn;
    // Put in its place, strongest first.
    size_t place_in = found.count;
    while (place_in > 0 && height[place_in - 1] < here) --place_in;
    if (place_in == most) continue;
    for (size_t i = most - 1; i > place_in; --i) {
      height[i] = height[i - 1];
      found.angle_rad[i] = found.angle_rad[i - 1];
    }
    height[place_in] = here;
    found.angle_rad[place_in] = angle;
    found.count = std::min(found.count + 1, most);
  }
  return found;
}

}  // namespace

DominantAngles FindDominantAngles(const FloatImage& image,
                                  const ImagePlace& place) {
  Harmonics harmonics;
  HWY_DYNAMIC_DISPATCH(SumHarmonics)
  (image.row(0), image.stride(), image.width(), image.height(),
   static_cast<int>(std::lround(place.x)),
   static_cast<int>(std::lround(place.y)), WindowOf(place.sigma), harmonics);
  const AngleTables& tables = Angles();
  std::array<float, kAngles> histogram;
  histogram.fill(harmonics[0]);
  for (size_t k = 0; k < kHarmonics; ++k) {
    const float real = harmonics[1 + 2 * k];
    const float imaginary = harmonics[2 + 2 * k];
    for (size_t a = 0; a < kAngles; ++a) {
      histogram[a] +=
          real * tables.cosine[k][a] + imaginary * tables.sine[k][a];
    }
  }
  if (!(harmonics[0] > 1e-3F)) return {};
  return PeaksOf(histogram, kFastAngles);
}

DominantAngles FindLoweAngles(const FloatImage& image,
                              const ImagePlace& place) {
  const Window window =
      MakeWindow(kLoweAngleWindow * place.sigma, kLoweAngleWindowReach);
  std::array<float, kAngles> sums;
  HWY_DYNAMIC_DISPATCH(SumDirections)
  (image.row(0), image.stride(), image.width(), image.height(),
   static_cast<int>(std::lround(place.x)),
   static_cast<int>(std::lround(place.y)), window, sums.data());
  std::array<float, kAngles> smooth;
  for (size_t a = 0; a < kAngles; ++a) {
    const auto at = [&](size_t off) { return sums[(a + off) % kAngles]; };
    smooth[a] = (at(kAngles - 2) + at(2)) / 16 + (at(kAngles - 1) + at(1)) / 4 +
                at(0) * 3 / 8;
  }
  return PeaksOf(smooth, DominantAngles::kMax);
}

SiftDescriptor DescribePlace(const FloatImage& image, const ImagePlace& place,
                             float angle_rad, float cell_sigmas) {
  const float step =
      place.sigma * cell_sigmas * kPatchCells / static_cast<float>(kSide);
  std::array<float, kSamples + 16> patch;
  HWY_DYNAMIC_DISPATCH(SamplePatch)
  (image.row(0), image.stride(), image.width(), image.height(), place.x,
   place.y, step * std::cos(angle_rad), step * std::sin(angle_rad), Patch(),
   patch.data());
  std::array<float, SiftDescriptor::kDimensions> histogram;
  HWY_DYNAMIC_DISPATCH(FillHistogram)(patch.data(), Patch(), histogram.data());
  SiftDescriptor descriptor;
  HWY_DYNAMIC_DISPATCH(QuantizeHistogram)
  (histogram.data(), kLargestShare, SiftDescriptor::kScale,
   descriptor.values.data());
  return descriptor;
}

}  // namespace treeline::features
#endif  // HWY_ONCE
