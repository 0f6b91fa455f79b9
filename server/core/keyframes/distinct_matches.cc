#include "server/core/keyframes/distinct_matches.h"

#include <cstdint>
#include <vector>

#include "common/geometry/vector3.h"
#include "server/core/features/sift_matching.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

geometry::Vec3 PointOf(const KeyframeFeature& feature) {
  const auto& [x, y, z] = feature.position_in_world;
  return {x, y, z};
}

}  // namespace

size_t CountDistinct(const features::SiftFeatures& features,
                     const KeyframeMap& map,
                     std::span<const KeyframeMatch> matches) {
  const std::span<const KeyframeFeature> known = map.features();
  // What is like one of a pair may be of the other's word.
  std::vector<features::SiftDescriptor> pairs;
  pairs.reserve(2 * matches.size());
  for (const KeyframeMatch& match : matches) {
    pairs.push_back(features.descriptors[match.feature]);
    pairs.push_back({known[match.known].descriptor});
  }
  const std::vector<std::vector<uint32_t>> alike =
      map.index().FeaturesLike(pairs);
  size_t distinct = 0;
  std::vector<features::SiftDescriptor> elsewhere;
  for (size_t i = 0; i < matches.size(); ++i) {
    elsewhere.clear();
    for (const size_t p : {2 * i, 2 * i + 1}) {
      for (const uint32_t f : alike[p]) {
        if (geometry::Norm(PointOf(known[f]) - matches[i].point_in_world) >
            kElsewhere_m) {
          elsewhere.push_back({known[f].descriptor});
        }
      }
    }
    features::NearestSift nearest;
    if (!elsewhere.empty()) {
      features::FindNearestSift(
          std::span(pairs).subspan(2 * i, 1),
          {.data = elsewhere[0].values.data(), .size = elsewhere.size()},
          std::span(&nearest, 1));
    }
    distinct += static_cast<double>(matches[i].squared_distance) <
                kMaxDistinctRatio * kMaxDistinctRatio *
                    static_cast<double>(nearest.squared_distance);
  }
  return distinct;
}

}  // namespace treeline::keyframes
