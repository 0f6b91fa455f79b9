#include "nav_agent/rgbd_slam/tracker.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace treeline::rgbd_slam {
namespace {

constexpr size_t kLocalLandmarks = 4000;
constexpr size_t kLocalKeyframes = 15;
constexpr size_t kCandidates = 8;

std::vector<PointSighting> SightingsOf(const SlamMap& map,
                                       const std::vector<FeatureMatch>& matches,
                                       const FeatureSet& features) {
  std::vector<PointSighting> sightings;
  sightings.reserve(matches.size());
  for (const FeatureMatch& match : matches) {
    const ImageFeature& feature = features[match.feature];
    sightings.push_back(
        {.point_in_map = map.landmark(match.landmark).point_in_map,
         .pixel = feature.pixel,
         .depth_m = feature.depth_m,
         .sigma_px = OctaveScale(feature.octave)});
  }
  return sightings;
}

TrackedFrame ToTrackedFrame(const SolvedPose& solved,
                            const std::vector<FeatureMatch>& matches) {
  TrackedFrame tracked{.camera_from_map = solved.camera_from_map,
                       .matches = {}};
  for (size_t i = 0; i < matches.size(); ++i) {
    if (solved.is_inlier[i]) tracked.matches.push_back(matches[i]);
  }
  return tracked;
}

}  // namespace

Tracker::Tracker(const RgbdSlamOptions& options, SlamMap* map)
    : options_(options), map_(*map) {}

std::vector<int> Tracker::LocalLandmarks(
    const std::vector<FeatureMatch>& seen) const {
  std::vector<int> landmarks;
  for (const FeatureMatch& match : seen) {
    if (!map_.landmark(match.landmark).is_erased) {
      landmarks.push_back(match.landmark);
    }
  }
  std::vector<Covisible> keyframes = map_.KeyframesThatSee(landmarks, 3);
  if (keyframes.size() > kLocalKeyframes) keyframes.resize(kLocalKeyframes);
  if (keyframe_ >= 0) keyframes.push_back({keyframe_, 0});
  return map_.LandmarksOf(keyframes, kLocalLandmarks);
}

std::optional<TrackedFrame> Tracker::Refine(
    std::span<const int> landmarks, const FeatureSet& features,
    const geometry::Rigid3& camera_from_map, double radius_px, double ratio,
    int min_inliers) const {
  const std::vector<FeatureMatch> matches = MatchByProjection(
      map_, landmarks, features, camera_from_map,
      {.radius_px = radius_px, .max_distance = 80, .ratio = ratio}, nullptr);
  if (static_cast<int>(matches.size()) < min_inliers) return std::nullopt;
  const SolvedPose solved = SolvePose(SightingsOf(map_, matches, features),
                                      map_.pinhole(), camera_from_map);
  if (solved.inliers < min_inliers) return std::nullopt;
  return ToTrackedFrame(solved, matches);
}

std::optional<TrackedFrame> Tracker::FindFrom(int keyframe,
                                              const FeatureSet& features,
                                              int min_inliers,
                                              uint64_t stream) const {
  const std::vector<FeatureMatch> matches =
      MatchByDescriptor(map_, keyframe, features);
  const int few = std::max(8, min_inliers / 2);
  const std::optional<SolvedPose> solved =
      FindPose(SightingsOf(map_, matches, features), map_.pinhole(), few,
               options_.seed, stream);
  if (!solved) return std::nullopt;
  std::vector<Covisible> keyframes =
      map_.CovisibleWith(keyframe, options_.min_shared);
  if (keyframes.size() > kLocalKeyframes) keyframes.resize(kLocalKeyframes);
  keyframes.insert(keyframes.begin(), {keyframe, 0});
  const std::vector<int> landmarks =
      map_.LandmarksOf(keyframes, kLocalLandmarks);
  std::optional<TrackedFrame> found =
      Refine(landmarks, features, solved->camera_from_map, 10, 0.9, few);
  if (!found) return std::nullopt;
  return Refine(landmarks, features, found->camera_from_map, 4, 0.9,
                min_inliers);
}

std::optional<TrackedFrame> Tracker::Track(const FeatureSet& features) {
  if (keyframe_ < 0) return std::nullopt;
  const geometry::Rigid3 predicted =
      velocity_ ? *velocity_ * camera_from_map_ : camera_from_map_;
  const std::vector<int> about = LocalLandmarks(last_matches_);
  const int min = options_.min_inliers;
  std::optional<TrackedFrame> found =
      Refine(about, features, predicted, 12, 0.85, min);
  if (!found) found = Refine(about, features, predicted, 35, 0.8, min);
  if (!found) {
    const auto stream = static_cast<uint64_t>(map_.keyframe_count());
    found = FindFrom(keyframe_, features, min, stream);
  }
  if (!found) return std::nullopt;
  const std::vector<int> local = LocalLandmarks(found->matches);
  std::vector<int> visible;
  const std::vector<FeatureMatch> matches = MatchByProjection(
      map_, local, features, found->camera_from_map,
      {.radius_px = 5, .max_distance = 80, .ratio = 0.9}, &visible);
  const SolvedPose solved = SolvePose(SightingsOf(map_, matches, features),
                                      map_.pinhole(), found->camera_from_map);
  for (const int l : visible) ++map_.landmark(l).visible;
  if (solved.inliers < min) return std::nullopt;
  TrackedFrame tracked = ToTrackedFrame(solved, matches);
  for (const FeatureMatch& match : tracked.matches) {
    ++map_.landmark(match.landmark).found;
  }
  return tracked;
}

std::optional<TrackedFrame> Tracker::Relocalize(const FeatureSet& features,
                                                const WordIndex& index,
                                                uint64_t stream) {
  const std::vector<double> scores = index.Score(features);
  std::vector<std::pair<double, int>> ranked;
  for (size_t k = 0; k < scores.size(); ++k) {
    ranked.emplace_back(-scores[k], static_cast<int>(k));
  }
  std::sort(ranked.begin(), ranked.end());
  if (ranked.size() > kCandidates) ranked.resize(kCandidates);
  for (const auto& [score, keyframe] : ranked) {
    std::optional<TrackedFrame> found =
        FindFrom(keyframe, features, 2 * options_.min_inliers,
                 stream + static_cast<uint64_t>(keyframe) * 1000003);
    if (!found) continue;
    found->is_relocalized = true;
    velocity_.reset();
    keyframe_ = keyframe;
    return found;
  }
  return std::nullopt;
}

void Tracker::SetPlace(const TrackedFrame& place, int keyframe) {
  const bool is_continuous =
      keyframe_ >= 0 && !place.is_relocalized && !last_matches_.empty();
  velocity_.reset();
  if (is_continuous) {
    velocity_ = place.camera_from_map * camera_from_map_.Inverse();
  }
  camera_from_map_ = place.camera_from_map;
  last_matches_ = place.matches;
  keyframe_ = keyframe;
}

void Tracker::SetLost() {
  velocity_.reset();
  last_matches_.clear();
}

void Tracker::Correct(const geometry::Rigid3& new_from_old) {
  camera_from_map_ = camera_from_map_ * new_from_old.Inverse();
}

}  // namespace treeline::rgbd_slam
