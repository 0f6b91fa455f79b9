#include "nav_agent/rgbd_slam/feature_matching.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace treeline::rgbd_slam {
namespace {

constexpr int kNoDistance = 257;

// The best of a landmark's candidates, and what must be said against it.
struct Best {
  int feature = -1;
  int distance = kNoDistance;
  int octave = 0;
  int second_distance = kNoDistance;
  int second_octave = -1;
};

Best BestOf(const std::vector<int>& candidates, const FeatureSet& features,
            const Landmark& landmark, const ExpectedSighting& expected) {
  Best best;
  for (const int f : candidates) {
    const ImageFeature& feature = features[f];
    if (std::abs(feature.octave - expected.octave) > 1) continue;
    if (feature.depth_m > 0 && std::abs(feature.depth_m - expected.depth_m) >
                                   0.05 + 0.1 * expected.depth_m) {
      continue;
    }
    const int distance =
        HammingDistance(feature.descriptor, landmark.descriptor);
    if (distance < best.distance) {
      best.second_distance = best.distance;
      best.second_octave = best.octave;
      best.feature = f;
      best.distance = distance;
      best.octave = feature.octave;
    } else if (distance < best.second_distance) {
      best.second_distance = distance;
      best.second_octave = feature.octave;
    }
  }
  return best;
}

// Matches whose turn about the optical axis is not that of most others are
// wrong: keeps those of the fullest bins of 12 degrees and their neighbours.
class TurnVote {
 public:
  void Add(double turn_rad) { ++counts_[BinOf(turn_rad)]; }
  bool Accepts(double turn_rad) const {
    const auto top = static_cast<size_t>(
        std::max_element(counts_.begin(), counts_.end()) - counts_.begin());
    const size_t apart = (BinOf(turn_rad) + kBins - top) % kBins;
    return apart <= 1 || apart == kBins - 1;
  }

 private:
  static constexpr size_t kBins = 30;
  static size_t BinOf(double turn_rad) {
    constexpr double kTurn = 2 * std::numbers::pi;
    const double share = turn_rad / kTurn - std::floor(turn_rad / kTurn);
    return std::min(kBins - 1, static_cast<size_t>(share * kBins));
  }

  std::array<int, kBins> counts_{};
};

}  // namespace

bool Expect(const Landmark& landmark, const Pinhole& pinhole,
            const FeatureSet& features, const geometry::Rigid3& camera_from_map,
            geometry::Vec3 camera_in_map, ExpectedSighting* expected) {
  constexpr double kMinCosine = 0.5;
  const geometry::Vec3 p = camera_from_map * landmark.point_in_map;
  if (p.z < 0.1) return false;
  expected->pixel = pinhole.Project(p);
  if (!features.Contains(expected->pixel)) return false;
  expected->depth_m = p.z;
  const geometry::Vec3 to_camera = camera_in_map - landmark.point_in_map;
  const double distance_m = geometry::Norm(to_camera);
  if (geometry::Dot(to_camera, landmark.direction_in_map) <
      kMinCosine * distance_m) {
    return false;
  }
  const double ratio = landmark.finest_distance_m / distance_m;
  const double octave = std::log(ratio) / std::log(kPyramidScale);
  if (octave < -1.5 || octave > kPyramidLevels + 0.5) return false;
  expected->octave =
      std::clamp(static_cast<int>(std::lround(octave)), 0, kPyramidLevels - 1);
  return true;
}

std::vector<FeatureMatch> MatchByProjection(
    const SlamMap& map, std::span<const int> landmarks,
    const FeatureSet& features, const geometry::Rigid3& camera_from_map,
    const ProjectionSearch& search, std::vector<int>* visible) {
  const geometry::Vec3 camera_in_map = camera_from_map.Inverse().translation;
  // For each feature, the landmark that it fits best.
  struct Claim {
    int landmark = kNoLandmark;
    int distance = kNoDistance;
  };
  std::vector<Claim> claims(static_cast<size_t>(features.size()));
  std::vector<int> candidates;
  for (const int l : landmarks) {
    const Landmark& landmark = map.landmark(l);
    ExpectedSighting expected;
    if (landmark.is_erased ||
        !Expect(landmark, map.pinhole(), features, camera_from_map,
                camera_in_map, &expected)) {
      continue;
    }
    if (visible != nullptr) visible->push_back(l);
    features.Near(expected.pixel,
                  search.radius_px * OctaveScale(expected.octave), &candidates);
    const Best best = BestOf(candidates, features, landmark, expected);
    if (best.distance > search.max_distance) continue;
    if (best.octave == best.second_octave &&
        best.distance > search.ratio * best.second_distance) {
      continue;
    }
    Claim& claim = claims[static_cast<size_t>(best.feature)];
    if (best.distance < claim.distance) claim = {l, best.distance};
  }
  std::vector<FeatureMatch> matches;
  for (size_t f = 0; f < claims.size(); ++f) {
    if (claims[f].landmark == kNoLandmark) continue;
    matches.push_back({static_cast<int>(f), claims[f].landmark});
  }
  return matches;
}

std::vector<FeatureMatch> MatchByDescriptor(const SlamMap& map, int k,
                                            const FeatureSet& features) {
  constexpr int kMaxDistance = 64;
  constexpr double kRatio = 0.85;
  struct Pair {
    int feature = 0;
    int other = 0;
    double turn_rad = 0;
  };
  const MapKeyframe& keyframe = map.keyframe(k);
  // For each feature of the keyframe, the feature that chose it.
  std::vector<int> best_distances(keyframe.landmarks.size(), kNoDistance);
  std::vector<Pair> pairs;
  TurnVote vote;
  for (int f = 0; f < features.size(); ++f) {
    int best = -1;
    int distance = kNoDistance;
    int second = kNoDistance;
    for (size_t g = 0; g < keyframe.landmarks.size(); ++g) {
      if (keyframe.landmarks[g] == kNoLandmark) continue;
      const int d =
          HammingDistance(features[f].descriptor,
                          keyframe.features[static_cast<int>(g)].descriptor);
      if (d < distance) {
        second = distance;
        distance = d;
        best = static_cast<int>(g);
      } else if (d < second) {
        second = d;
      }
    }
    if (distance > kMaxDistance || distance > kRatio * second) continue;
    int& held = best_distances[static_cast<size_t>(best)];
    if (distance >= held) continue;
    held = distance;
    const double turn_rad =
        features[f].angle_rad - keyframe.features[best].angle_rad;
    std::erase_if(pairs, [best](const Pair& p) { return p.other == best; });
    pairs.push_back({f, best, turn_rad});
  }
  for (const Pair& pair : pairs) vote.Add(pair.turn_rad);
  std::vector<FeatureMatch> matches;
  for (const Pair& pair : pairs) {
    if (!vote.Accepts(pair.turn_rad)) continue;
    matches.push_back(
        {pair.feature, keyframe.landmarks[static_cast<size_t>(pair.other)]});
  }
  return matches;
}

}  // namespace treeline::rgbd_slam
