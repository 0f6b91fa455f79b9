#include "server/core/keyframes/keyframe_features.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "common/base/status_macros.h"
#include "server/core/features/sift_matching.h"

namespace treeline {
namespace {

// Sides at which images are halved (px).
constexpr int kHalvedSide_px = 512;
// Features that keyframes are compared by.
constexpr size_t kCompared = 300;
// Keyframes are alike from so many matches on.
constexpr size_t kMinAlike = 6;
// OpenCV's contrast threshold.
constexpr double kContrast = 0.02;

// Every pixel is the mean of 2 x 2.
ColorImage HalfOf(const ColorImage& image) {
  ColorImage half;
  half.width = image.width / 2;
  half.height = image.height / 2;
  half.rgb.resize(3 * static_cast<size_t>(half.width) *
                  static_cast<size_t>(half.height));
  const size_t stride = 3 * static_cast<size_t>(image.width);
  uint8_t* out = half.rgb.data();
  for (int y = 0; y < half.height; ++y) {
    const uint8_t* in = image.rgb.data() + 2 * static_cast<size_t>(y) * stride;
    for (int x = 0; x < half.width; ++x, in += 6) {
      for (size_t c = 0; c < 3; ++c) {
        const int sum = in[c] + in[c + 3] + in[c + stride] + in[c + stride + 3];
        *out++ = static_cast<uint8_t>((sum + 2) / 4);
      }
    }
  }
  return half;
}

}  // namespace

absl::StatusOr<SiftFeatures> ExtractKeyframeSift(const ColorImage& image,
                                                 int max_features) {
  const SiftOptions options{.max_features = max_features,
                            .contrast = kContrast};
  if (std::max(image.width, image.height) < kHalvedSide_px) {
    return ExtractSift(image, options);
  }
  TL_ASSIGN_OR_RETURN(SiftFeatures features,
                      ExtractSift(HalfOf(image), options));
  for (SiftKeypoint& keypoint : features.keypoints) {
    keypoint.pixel = {2 * keypoint.pixel.x + 0.5, 2 * keypoint.pixel.y + 0.5};
    keypoint.diameter_px *= 2;
  }
  return features;
}

std::vector<KeyframeMatch> MatchKeyframes(const SiftFeatures& features,
                                          const KeyframeMap& map,
                                          std::span<const size_t> keyframes,
                                          double max_ratio) {
  constexpr uint32_t kNobody = std::numeric_limits<uint32_t>::max();
  std::vector<KeyframeMatch> matches;
  std::vector<NearestSift> nearest(features.size());
  for (const size_t k : keyframes) {
    const std::span<const KeyframeFeature> known = map.features(k);
    if (known.empty()) continue;
    FindNearestSift(
        features.descriptors,
        {known[0].descriptor.data(), sizeof(KeyframeFeature), known.size()},
        nearest);
    // Of the features that a keyframe's is nearest to, the nearest.
    std::vector<uint32_t> back(known.size(), kNobody);
    for (uint32_t i = 0; i < nearest.size(); ++i) {
      uint32_t& other = back[nearest[i].index];
      if (other == kNobody ||
          nearest[i].squared_distance < nearest[other].squared_distance) {
        other = i;
      }
    }
    for (size_t j = 0; j < known.size(); ++j) {
      if (back[j] == kNobody) continue;
      const NearestSift& match = nearest[back[j]];
      const double ratio =
          std::sqrt(static_cast<double>(match.squared_distance) /
                    std::max(1, match.second_squared_distance));
      if (ratio > max_ratio) continue;
      const auto& [x, y, z] = known[j].position_in_world;
      matches.push_back(
          {features.keypoints[back[j]].pixel, Vec3{x, y, z}, ratio});
    }
  }
  std::ranges::stable_sort(matches, {}, &KeyframeMatch::ratio);
  return matches;
}

std::vector<size_t> MostAlike(const SiftFeatures& features,
                              const KeyframeMap& map, size_t count,
                              double max_ratio) {
  SiftFeatures compared;
  const size_t kept = std::min(kCompared, features.size());
  compared.keypoints.assign(
      features.keypoints.begin(),
      features.keypoints.begin() + static_cast<std::ptrdiff_t>(kept));
  compared.descriptors.assign(
      features.descriptors.begin(),
      features.descriptors.begin() + static_cast<std::ptrdiff_t>(kept));
  std::vector<std::pair<size_t, size_t>> alike;  // matches, keyframe
  for (size_t k = 0; k < map.size(); ++k) {
    const size_t matches =
        MatchKeyframes(compared, map, std::span(&k, 1), max_ratio).size();
    if (matches >= kMinAlike) alike.emplace_back(matches, k);
  }
  std::ranges::stable_sort(alike, std::ranges::greater(),
                           [](const auto& a) { return a.first; });
  std::vector<size_t> result;
  for (size_t i = 0; i < std::min(count, alike.size()); ++i) {
    result.push_back(alike[i].second);
  }
  return result;
}

}  // namespace treeline
