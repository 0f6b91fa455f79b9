#include "server/core/localizer/keyframe_source.h"

#include <algorithm>
#include <vector>

#include "common/base/status_macros.h"
#include "server/core/keyframes/distinct_matches.h"
#include "server/core/keyframes/keyframe_features.h"
#include "server/core/pose/ray_refinement.h"

namespace treeline::localizer {

static_assert(PoseSource<KeyframeSource>);

std::vector<size_t> KeyframeSource::Choose(
    Query& query, const features::SiftFeatures& features,
    std::span<const Candidate> earlier) const {
  const size_t count = static_cast<size_t>(count_);
  if (choice_ == KeyframeChoice::kMostSimilar) {
    return keyframes::MostSimilarKeyframes(features, *map_, count,
                                           kMaxKeyframeRatio);
  }
  const double max_angle_rad = keyframes::MaxKeyframeAngle_rad(query.camera());
  if (choice_ == KeyframeChoice::kNearPriors) {
    const geometry::PosePriors near = query.options().priors.Widened(
        kMaxPriorKeyframeDistance_m, max_angle_rad);
    std::vector<size_t> allowed;
    for (size_t k = 0; k < map_->size(); ++k) {
      if (near.Allows(map_->world_from_camera(k))) allowed.push_back(k);
    }
    return keyframes::MostSimilarKeyframes(features, *map_, allowed, count,
                                           kMaxKeyframeRatio);
  }
  for (size_t i = earlier.size(); i > 0; --i) {
    const std::optional<pose::RefinedPose>& pose = earlier[i - 1].pose;
    if (!pose) continue;
    return map_->Nearest(pose->world_from_camera, max_angle_rad, count);
  }
  return {};
}

absl::StatusOr<size_t> KeyframeSource::Observe(
    Query& query, std::span<const Candidate> earlier,
    KeyframeObservations& seen) const {
  const StageTimer timer(query.timings().features_ms);
  const features::SiftFeatures& features =
      query.keyframe_features(map_->sift_kind());
  pose::RayPredictions& scene = seen.scene;
  const double variance = kKeyframePointSigma_m * kKeyframePointSigma_m;
  for (const keyframes::KeyframeMatch& match : keyframes::MatchKeyframes(
           features, *map_, Choose(query, features, earlier),
           kMaxKeyframeRatio)) {
    const std::optional<camera::Pixel> ray =
        query.camera().Unproject(match.pixel);
    if (!ray) continue;
    seen.pixel.push_back(match.pixel);
    seen.match.push_back(match);
    scene.ray.push_back(*ray);
    scene.predictions.push_back(
        {match.point_in_world, {variance, 0, 0, variance, 0, variance}});
  }
  scene.ray_sigma.assign(scene.size(), kKeypointSigma_px * query.pixel());
  return seen.size();
}

pose::RaySolver KeyframeSource::Solver(Query& query,
                                       const KeyframeObservations& seen) const {
  return {seen.scene,
          {.inlier_distance = kKeyframeRansacInlier_px * query.pixel()}};
}

std::optional<pose::RefinedPose> KeyframeSource::Refine(
    Query& query, const KeyframeObservations& seen,
    const geometry::Rigid3& world_from_camera) const {
  return pose::RefineRays(
      seen.scene, world_from_camera,
      {.robust_scale = RobustScale(query),
       .inlier_distance = kKeyframeInlier_px * query.pixel()});
}

double KeyframeSource::DistinctShare(Query& query,
                                     const KeyframeObservations& seen,
                                     const pose::RefinedPose& pose) const {
  const StageTimer timer(query.timings().features_ms);
  std::vector<keyframes::KeyframeMatch> inliers;
  for (size_t i = 0; i < seen.size(); ++i) {
    if (pose.supported[i] >= 0) inliers.push_back(seen.match[i]);
  }
  if (inliers.empty()) return 1;
  // Sure ones and doubtful ones alike.
  const size_t asked = std::min<size_t>(inliers.size(), kDistinctMatches);
  for (size_t i = 0; i < asked; ++i) {
    inliers[i] = inliers[i * inliers.size() / asked];
  }
  inliers.resize(asked);
  return static_cast<double>(keyframes::CountDistinct(
             query.keyframe_features(map_->sift_kind()), *map_, inliers)) /
         static_cast<double>(asked);
}

}  // namespace treeline::localizer
