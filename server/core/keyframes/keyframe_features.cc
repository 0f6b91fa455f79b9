#include "server/core/keyframes/keyframe_features.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "server/core/features/sift_extractor.h"
#include "server/core/features/sift_matching.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

// Of a frame and of a keyframe, so many features are compared.
struct Compared {
  size_t of_frame = 0;
  size_t of_keyframe = 0;
};
// All keyframes; then the most alike of them.
constexpr Compared kCoarse = {.of_frame = kCoarseFrameFeatures,
                              .of_keyframe = kCoarseKeyframeFeatures};
constexpr Compared kFine = {.of_frame = kFrameFeatures,
                            .of_keyframe = kMaxKeyframeFeatures};

// Every pixel is the mean of 2 x 2.
image::ColorImage HalfOf(const image::ColorImage& image) {
  image::ColorImage half;
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

// Two features that are each other's nearest.
struct Pair {
  uint32_t query = 0;
  uint32_t known = 0;
  double ratio = 1;
  int32_t squared_distance = 0;
};

// In the order of the keyframe's features.
void FindPairs(std::span<const features::SiftDescriptor> queries,
               std::span<const KeyframeFeature> known, double max_ratio,
               std::vector<Pair>& pairs) {
  constexpr uint32_t kNobody = std::numeric_limits<uint32_t>::max();
  pairs.clear();
  if (known.empty()) return;
  std::vector<features::NearestSift> nearest(queries.size());
  features::FindNearestSift(
      queries,
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
  for (uint32_t j = 0; j < known.size(); ++j) {
    if (back[j] == kNobody) continue;
    const features::NearestSift& match = nearest[back[j]];
    const double ratio = std::sqrt(static_cast<double>(match.squared_distance) /
                                   std::max(1, match.second_squared_distance));
    if (ratio <= max_ratio) {
      pairs.push_back({back[j], j, ratio, match.squared_distance});
    }
  }
}

template <typename T>
std::span<const T> AtMost(std::span<const T> values, size_t count) {
  return values.first(std::min(count, values.size()));
}

// Of these keyframes the `count` that share most features with a frame, and at
// least `least` of them; most first.
std::vector<size_t> WithMostMatches(const features::SiftFeatures& features,
                                    const KeyframeMap& map,
                                    std::span<const size_t> keyframes,
                                    const Compared& compared, size_t count,
                                    size_t least, double max_ratio) {
  const auto queries =
      AtMost(std::span(std::as_const(features.descriptors)), compared.of_frame);
  std::vector<std::pair<size_t, size_t>> alike;  // pairs, keyframe
  std::vector<Pair> pairs;
  for (const size_t k : keyframes) {
    FindPairs(queries, AtMost(map.features(k), compared.of_keyframe), max_ratio,
              pairs);
    if (pairs.size() >= least) alike.emplace_back(pairs.size(), k);
  }
  std::ranges::stable_sort(alike, std::ranges::greater(),
                           [](const auto& a) { return a.first; });
  std::vector<size_t> result;
  for (const auto& [shared, k] :
       AtMost(std::span(std::as_const(alike)), count)) {
    result.push_back(k);
  }
  return result;
}

}  // namespace

features::SiftFeatures ExtractKeyframeSift(const image::ColorImage& image,
                                           features::SiftKind kind,
                                           features::FastSiftOptions fast,
                                           features::FastSift& fast_sift) {
  if (kind == features::SiftKind::kFast) {
    fast.max_features = std::min<int>(fast.max_features, kMaxFastFeatures);
    return fast_sift.Extract(image, fast);
  }
  const features::SiftOptions options{.max_features = fast.max_features,
                                      .contrast = kSiftContrast};
  if (std::max(image.width, image.height) < kHalvedSide_px) {
    return features::ExtractSift(image, options);
  }
  features::SiftFeatures features =
      features::ExtractSift(HalfOf(image), options);
  for (features::SiftKeypoint& keypoint : features.keypoints) {
    keypoint.pixel = {2 * keypoint.pixel.x + 0.5, 2 * keypoint.pixel.y + 0.5};
    keypoint.diameter_px *= 2;
  }
  return features;
}

std::vector<KeyframeMatch> MatchKeyframes(
    const features::SiftFeatures& features, const KeyframeMap& map,
    std::span<const size_t> keyframes, double max_ratio) {
  std::vector<KeyframeMatch> matches;
  std::vector<Pair> pairs;
  for (const size_t k : keyframes) {
    const std::span<const KeyframeFeature> known = map.features(k);
    FindPairs(features.descriptors, known, max_ratio, pairs);
    for (const Pair& pair : pairs) {
      const auto& [x, y, z] = known[pair.known].position_in_world;
      matches.push_back({.pixel = features.keypoints[pair.query].pixel,
                         .point_in_world = geometry::Vec3{x, y, z},
                         .ratio = pair.ratio,
                         .feature = pair.query,
                         .known = static_cast<uint32_t>(&known[pair.known] -
                                                        map.features().data()),
                         .squared_distance = pair.squared_distance});
    }
  }
  std::ranges::stable_sort(matches, {}, &KeyframeMatch::ratio);
  return matches;
}

std::vector<size_t> MostSimilarKeyframes(const features::SiftFeatures& features,
                                         const KeyframeMap& map, size_t count,
                                         double max_ratio) {
  if (map.sift_kind() == features::SiftKind::kFast) {
    return map.index().MostSimilar(features.descriptors, count);
  }
  std::vector<size_t> all(map.size());
  std::iota(all.begin(), all.end(), size_t{0});
  return MostSimilarKeyframes(features, map, all, count, max_ratio);
}

std::vector<size_t> MostSimilarKeyframes(const features::SiftFeatures& features,
                                         const KeyframeMap& map,
                                         std::span<const size_t> keyframes,
                                         size_t count, double max_ratio) {
  return WithMostMatches(features, map,
                         WithMostMatches(features, map, keyframes, kCoarse,
                                         kShortlist, 1, max_ratio),
                         kFine, count, kMinSharedFeatures, max_ratio);
}

}  // namespace treeline::keyframes
