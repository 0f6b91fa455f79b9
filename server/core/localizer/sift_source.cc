#include "server/core/localizer/sift_source.h"

#include <algorithm>

#include "common/base/status_macros.h"
#include "server/core/pose/ray_refinement.h"

namespace treeline::localizer {

static_assert(PoseSource<SiftSource>);

void SiftSource::Append(const features::SiftFeatures& features,
                        std::span<const forest::SiftMatch> matches,
                        const Query& query, RayObservations& seen) const {
  // Squared ratios of distances: what is least like anything else is surest.
  std::vector<double> ratio(matches.size());
  std::vector<size_t> kept;
  std::vector<camera::Pixel> rays(matches.size());
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i].mode == forest::kNoLeaf) continue;
    ratio[i] = static_cast<double>(matches[i].distance) /
               std::max(1, matches[i].distance_elsewhere);
    if (!(ratio[i] < kMaxSiftRatio * kMaxSiftRatio)) continue;
    const std::optional<camera::Pixel> ray =
        query.camera().Unproject(features.keypoints[i].pixel);
    if (!ray) continue;
    rays[i] = *ray;
    kept.push_back(i);
  }
  std::ranges::stable_sort(kept, {}, [&](size_t i) { return ratio[i]; });
  for (const size_t i : kept) {
    seen.pixel.push_back(features.keypoints[i].pixel);
    seen.scene.ray.push_back(rays[i]);
    // The points' uncertainties are left out: points and poses were fitted to
    // each other by plain reprojection errors, and answers that weigh them
    // otherwise agree less with it (docs/explanation/structure-from-motion.md).
    seen.scene.predictions.push_back(
        {.mean_in_world = forest_->LeafMean(matches[i].mode),
         .covariance = {}});
  }
  seen.scene.ray_sigma.assign(kept.size(), kKeypointSigma_px * query.pixel());
}

absl::StatusOr<size_t> SiftSource::Observe(
    Query& query, std::span<const Candidate> /*earlier*/,
    RayObservations& seen) const {
  features::SiftFeatures features;
  {
    const StageTimer timer(query.timings().sample_ms);
    features = query.scratch().sift.Extract(
        query.color(), {.max_features = options_.features});
  }
  const StageTimer timer(query.timings().forest_ms);
  std::vector<forest::SiftMatch> matches(features.size());
  forest::MatchSift(*forest_, features.descriptors,
                    {.leaves_per_tree = options_.backtracking_leaves,
                     .same_place = kSameSiftPlace * viewing_distance_},
                    query.stop(), matches);
  TL_RETURN_IF_ERROR(query.CheckStop());
  Append(features, matches, query, seen);
  return seen.size();
}

pose::RaySolver SiftSource::Solver(Query& query,
                                   const RayObservations& seen) const {
  return {seen.scene,
          {.inlier_distance = kSiftRansacInlier_px * query.pixel()}};
}

std::optional<pose::RefinedPose> SiftSource::Refine(
    Query& query, const RayObservations& seen,
    const geometry::Rigid3& world_from_camera) const {
  return pose::RefineRays(seen.scene, world_from_camera,
                          {.robust_scale = kSiftRobustScale_px * query.pixel(),
                           .inlier_distance = kSiftInlier_px * query.pixel()});
}

}  // namespace treeline::localizer
