#include "server/core/features/fast_sift.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <utility>

#include "server/core/features/gradient_histograms.h"
#include "server/core/features/parameters.h"

namespace treeline::features {
namespace {

bool IsStronger(const ScaleSpaceExtremum& a, const ScaleSpaceExtremum& b) {
  return std::tie(b.contrast, a.octave, a.y, a.x, a.level) <
         std::tie(a.contrast, b.octave, b.y, b.x, b.level);
}

}  // namespace

// What is weak beside the rest of the picture is left out, so that a picture of
// another exposure has the same.
void FastSift::FindAllExtrema() {
  extrema_.clear();
  const size_t octaves = space_.octaves().size();
  if (octaves == 0) return;
  const ExtremumOptions options = {
      .least_contrast = std::max<float>(
          kMinContrast, kRelativeContrast * MeanDifference(space_)),
      .max_curvature_ratio = kMaxCurvatureRatio,
      .move_beyond = kMoveBeyond_px};
  for (size_t o = 0; o < octaves; ++o) {
    FindExtrema(space_, o, options, extrema_);
  }
}

// Orders the extrema by contrast, each behind those that are stronger in its
// cell of a grid: what is the n-th in a cell counts an n-th. Keeps `count`.
void FastSift::Rank(size_t count) {
  std::ranges::sort(extrema_, IsStronger);
  const ScaleSpace::Octave& size = space_.octaves()[0];
  const int columns = size.width() / kGridCell_px + 1;
  std::vector<int> in_cell(
      static_cast<size_t>(columns * (size.height() / kGridCell_px + 1)));
  std::vector<std::pair<float, uint32_t>> order;
  order.reserve(extrema_.size());
  for (size_t i = 0; i < extrema_.size(); ++i) {
    const ScaleSpaceExtremum& e = extrema_[i];
    const float pixel = static_cast<float>(1u << e.octave);
    const int column = static_cast<int>(e.x * pixel) / kGridCell_px;
    const int row = static_cast<int>(e.y * pixel) / kGridCell_px;
    int& rank = in_cell[static_cast<size_t>(row * columns + column)];
    ++rank;
    order.emplace_back(
        -e.contrast / std::pow(static_cast<float>(rank), kCrowding),
        static_cast<uint32_t>(i));
  }
  std::ranges::sort(order);
  if (order.size() > count) order.resize(count);
  std::vector<ScaleSpaceExtremum> ranked;
  ranked.reserve(order.size());
  for (const auto& [key, i] : order) ranked.push_back(extrema_[i]);
  extrema_ = std::move(ranked);
}

SiftFeatures FastSift::Extract(const image::ColorImage& image,
                               const FastSiftOptions& options) {
  SiftFeatures features;
  const size_t most = static_cast<size_t>(std::max(0, options.max_features));
  space_.Assign(image, options.least_reduction);
  FindAllExtrema();
  if (extrema_.empty()) return features;
  Rank(most);
  features.keypoints.reserve(most);
  features.descriptors.reserve(most);
  for (const ScaleSpaceExtremum& e : extrema_) {
    const auto layer = static_cast<size_t>(std::lround(e.level));
    const FloatImage& level = space_.octaves()[e.octave].gaussian[layer];
    const ImagePlace place{e.x, e.y, space_.Sigma(e.level)};
    DominantAngles angles{.angle_rad = {}, .count = 1};
    if (!options.upright) angles = FindDominantAngles(level, place);
    for (size_t a = 0; a < angles.count && features.size() < most; ++a) {
      const float angle = angles.angle_rad[a];
      features.keypoints.push_back(KeypointOf(space_, e, angle));
      features.descriptors.push_back(
          DescribePlace(level, place, angle, kCellSize));
    }
  }
  return features;
}

}  // namespace treeline::features
