#include "server/core/features/sift_extractor.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <tuple>

#include "server/core/features/gradient_histograms.h"

namespace treeline::features {
namespace {

constexpr int kMinSize_px = 8;
// Lowe's, as OpenCV has them.
constexpr float kBaseBlur = 1.6F;
constexpr float kReach = 4;
constexpr float kMaxEdgeRatio = 10;
constexpr float kCellBlurs = 3;
constexpr size_t kDirections = 8;
// An octave this small has no pixel that is far enough from its edges.
constexpr int kMinOctave_px = 12;
// The camera's blur is taken for half a pixel, one of the doubled image.
constexpr float kWholeBlur = 0.5F;
constexpr float kDoubledBlur = 1;
// Where the first pixel lies in the image, of both.
constexpr double kOrigin_px = -0.25;

// Working memory of larger pictures, 37 bytes a pixel, and that of the doubled
// image is not kept: each thread and scene has an object.
constexpr int kMaxKept_px = 2'000'000;

constexpr ScaleSpaceOptions kWhole = {.base_blur_px = kBaseBlur,
                                      .picture_blur_px = kWholeBlur,
                                      .kernel_reach = kReach,
                                      .min_octave_side_px = kMinOctave_px};
constexpr ScaleSpaceOptions kDoubled = {.base_blur_px = kBaseBlur,
                                        .picture_blur_px = kDoubledBlur,
                                        .kernel_reach = kReach,
                                        .min_octave_side_px = kMinOctave_px,
                                        .max_octaves = 1};

constexpr float kRadPerDeg = static_cast<float>(std::numbers::pi / 180);

// Largest first: a total order within an octave.
bool IsBefore(const ScaleSpaceExtremum& a, const ScaleSpaceExtremum& b) {
  return std::tie(b.level, b.contrast, a.y, a.x) <
         std::tie(a.level, a.contrast, b.y, b.x);
}

// From different pixels.
bool IsSame(const ScaleSpaceExtremum& a, const ScaleSpaceExtremum& b) {
  return std::tie(a.level, a.y, a.x) == std::tie(b.level, b.y, b.x);
}

// As OpenCV lays it out: directions are counted against the clock.
SiftDescriptor DescribeAt(const FloatImage& level, const ImagePlace& place,
                          float angle_rad) {
  SiftDescriptor descriptor =
      DescribePlace(level, place, angle_rad, kCellBlurs);
  for (size_t cell = 0; cell < descriptor.values.size(); cell += kDirections) {
    const auto first = descriptor.values.begin() + cell;
    std::reverse(first + 1, first + kDirections);
  }
  return descriptor;
}

// The octave and layer that a diameter belongs to, which is
// 2 * 1.6 * 2^(octave + layer / 3), with octaves from -1 and layers from 1 to
// 3.
struct PyramidPlace {
  int octave = 0;
  int layer = 0;
};
PyramidPlace PlaceOfDiameter(float diameter_px, int octaves) {
  constexpr int kLayers = ScaleSpace::kLayers;
  const double level =
      kLayers * std::log2(static_cast<double>(std::max(diameter_px, 0.1F)) /
                          static_cast<double>(2 * kBaseBlur));
  const int rounded = std::clamp(static_cast<int>(std::lround(level)),
                                 1 - kLayers, kLayers * octaves);
  // Layers count from 1.
  const int octave = (rounded + kLayers - 1) / kLayers - 1;
  return {octave, rounded - kLayers * octave};
}

}  // namespace

SiftExtractor::SiftExtractor() : whole_(kWhole), doubled_(kDoubled) {}

void SiftExtractor::BeginWhole(const image::ColorImage& image) {
  ReduceToGray(image, 1, kLuma, row_sums_, gray_);
  ShiftByQuarter(gray_, moved_);
  whole_.Begin(moved_, 1, kOrigin_px);
}

void SiftExtractor::BeginDoubled() {
  DoubleInSize(gray_, moved_);
  doubled_.Begin(moved_, 0.5, kOrigin_px);
}

// Appends the features of an octave, up to max_features in all.
void SiftExtractor::AddOctave(ScaleSpace& space, size_t octave,
                              const SiftOptions& options,
                              SiftFeatures& features) {
  const size_t most = options.max_features > 0
                          ? static_cast<size_t>(options.max_features)
                          : SIZE_MAX;
  space.Complete(octave);
  extrema_.clear();
  FindExtrema(space, octave,
              {.least_contrast = static_cast<float>(options.contrast * 255 /
                                                    ScaleSpace::kLayers),
               .max_curvature_ratio = kMaxEdgeRatio},
              extrema_);
  std::ranges::sort(extrema_, IsBefore);
  extrema_.erase(std::unique(extrema_.begin(), extrema_.end(), IsSame),
                 extrema_.end());
  for (const ScaleSpaceExtremum& e : extrema_) {
    const auto layer = static_cast<size_t>(std::lround(e.level));
    const FloatImage& level = space.octaves()[octave].gaussian[layer];
    const ImagePlace place{e.x, e.y, space.Sigma(e.level)};
    const DominantAngles angles = FindLoweAngles(level, place);
    for (size_t a = 0; a < angles.count; ++a) {
      if (features.size() == most) return;
      const float angle_rad = angles.angle_rad[a];
      features.keypoints.push_back(KeypointOf(space, e, angle_rad));
      features.descriptors.push_back(DescribeAt(level, place, angle_rad));
    }
  }
}

SiftFeatures SiftExtractor::Extract(const image::ColorImage& image,
                                    const SiftOptions& options) {
  SiftFeatures features;
  if (std::min(image.width, image.height) < kMinSize_px) return features;
  const auto is_full = [&] {
    return options.max_features > 0 &&
           features.size() == static_cast<size_t>(options.max_features);
  };
  BeginWhole(image);
  for (size_t o = whole_.octaves().size(); o > 0 && !is_full(); --o) {
    AddOctave(whole_, o - 1, options, features);
  }
  if (!is_full()) {
    BeginDoubled();
    AddOctave(doubled_, 0, options, features);
    doubled_ = ScaleSpace(kDoubled);
    moved_ = FloatImage();
  }
  if (int64_t{1} * image.width * image.height > kMaxKept_px) {
    *this = SiftExtractor();
  }
  return features;
}

std::vector<SiftDescriptor> SiftExtractor::Describe(
    const image::ColorImage& image, std::span<const SiftKeypoint> keypoints) {
  std::vector<SiftDescriptor> descriptors(keypoints.size());
  if (keypoints.empty() || std::min(image.width, image.height) < kMinSize_px) {
    return descriptors;
  }
  BeginWhole(image);
  BeginDoubled();
  for (size_t i = 0; i < keypoints.size(); ++i) {
    const SiftKeypoint& k = keypoints[i];
    const auto [octave, layer] = PlaceOfDiameter(
        k.diameter_px, static_cast<int>(whole_.octaves().size()));
    const ScaleSpace& space = octave < 0 ? doubled_ : whole_;
    const size_t o = static_cast<size_t>(std::max(octave, 0));
    const double pixel = space.pixel() * static_cast<double>(1u << o);
    const ImagePlace place{
        .x = space.InOctave(k.pixel.x, o),
        .y = space.InOctave(k.pixel.y, o),
        .sigma = k.diameter_px / static_cast<float>(2 * pixel)};
    descriptors[i] =
        DescribeAt(space.octaves()[o].gaussian[static_cast<size_t>(layer)],
                   place, k.angle_deg * kRadPerDeg);
  }
  return descriptors;
}

SiftFeatures ExtractSift(const image::ColorImage& image,
                         const SiftOptions& options) {
  return SiftExtractor().Extract(image, options);
}

std::vector<SiftDescriptor> DescribeSift(
    const image::ColorImage& image, std::span<const SiftKeypoint> keypoints) {
  return SiftExtractor().Describe(image, keypoints);
}

}  // namespace treeline::features
