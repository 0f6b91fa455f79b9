#include "server/core/localizer/sift_generator.h"

#include <algorithm>

#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "server/core/pose/focal_estimate.h"
#include "server/core/pose/preemptive_ransac.h"
#include "server/core/pose/ray_refinement.h"
#include "server/core/pose/ray_solver.h"

namespace treeline::localizer {

SiftGenerator::SiftGenerator(const forest::ForestView& forest,
                             double viewing_distance,
                             const QueryOptions& options)
    : forest_(forest),
      places_(forest),
      viewing_distance_(viewing_distance),
      options_(options) {}

double SiftGenerator::Features::Ratio(size_t i) const {
  return static_cast<double>(match[i].distance) /
         std::max(1, match[i].distance_elsewhere);
}

bool SiftGenerator::Features::IsMatched(size_t i) const {
  return match[i].mode != forest::kNoLeaf &&
         Ratio(i) < kMaxSiftRatio * kMaxSiftRatio;
}

SiftGenerator::Features SiftGenerator::Extract(Query& query) const {
  const StageTimer timer(query.timings().sample_ms);
  Features features;
  features.found = query.scratch().sift.Extract(
      query.color(), {.max_features = options_.features});
  std::vector<features::SiftKeypoint>& keypoints = features.found.keypoints;
  for (size_t i = 0; i < keypoints.size(); ++i) {
    const std::optional<camera::Pixel> ray =
        query.camera().Unproject(keypoints[i].pixel);
    if (!ray) continue;
    keypoints[features.ray.size()] = keypoints[i];
    features.found.descriptors[features.ray.size()] =
        features.found.descriptors[i];
    features.ray.push_back(*ray);
  }
  keypoints.resize(features.size());
  features.found.descriptors.resize(features.size());
  features.match.resize(features.size());
  return features;
}

void SiftGenerator::AskForest(size_t step, int leaves, Query& query,
                              Features& features) const {
  const StageTimer timer(query.timings().forest_ms);
  std::vector<uint32_t> which;
  for (size_t i = 0; i < features.size(); i += step) {
    which.push_back(static_cast<uint32_t>(i));
  }
  forest::MatchSift(forest_, features.found.descriptors, which,
                    {.leaves_per_tree = leaves,
                     .same_place = kSameSiftPlace * viewing_distance_},
                    query.stop(), features.match);
}

RayObservations SiftGenerator::Observe(const Features& features,
                                       Query& query) const {
  std::vector<double> ratio(features.size());
  std::vector<size_t> kept;
  for (size_t i = 0; i < features.size(); ++i) {
    if (!features.IsMatched(i)) continue;
    ratio[i] = features.Ratio(i);
    kept.push_back(i);
  }
  std::ranges::stable_sort(kept, {}, [&](size_t i) { return ratio[i]; });
  RayObservations seen;
  for (const size_t i : kept) {
    seen.pixel.push_back(features.found.keypoints[i].pixel);
    seen.scene.ray.push_back(features.ray[i]);
    // The points' uncertainties are left out: points and poses were fitted to
    // each other by plain reprojection errors, and answers that weigh them
    // otherwise agree less with it (docs/explanation/structure-from-motion.md).
    seen.scene.predictions.push_back(
        {.mean_in_world = forest_.LeafMean(features.match[i].mode),
         .covariance = {}});
  }
  seen.scene.ray_sigma.assign(kept.size(), kKeypointSigma_px * query.pixel());
  return seen;
}

std::optional<pose::RefinedPose> SiftGenerator::Solve(
    const RayObservations& seen, Query& query) const {
  const pose::RaySolver solver(
      seen.scene, {.inlier_distance = kSiftRansacInlier_px * query.pixel()});
  const std::optional<geometry::Rigid3> pose = pose::PreemptiveRansac(
      solver,
      {.seed = base::MixBits(query.seed() + kForestRansacStream),
       .hypotheses = options_.hypotheses},
      query.stop());
  if (!pose) return std::nullopt;
  return Refine(seen, *pose, query);
}

std::optional<pose::RefinedPose> SiftGenerator::Refine(
    const RayObservations& seen, const geometry::Rigid3& world_from_camera,
    Query& query) const {
  return pose::RefineRays(seen.scene, world_from_camera,
                          {.robust_scale = kSiftRobustScale_px * query.pixel(),
                           .inlier_distance = kSiftInlier_px * query.pixel()});
}

std::optional<pose::RefinedPose> SiftGenerator::SolveGuided(
    Query& query, Features& features, RayObservations& seen) const {
  AskForest(kFirstSiftShare,
            std::min<int>(kFirstSiftLeaves, options_.backtracking_leaves),
            query, features);
  std::optional<pose::RefinedPose> pose =
      Solve(Observe(features, query), query);
  if (!pose || pose->inliers < kCertainSiftInliers) return std::nullopt;
  std::vector<uint32_t> others;
  for (size_t i = 0; i < features.size(); ++i) {
    if (!features.IsMatched(i)) others.push_back(static_cast<uint32_t>(i));
  }
  for (int round = 0; round < kSiftGuides && pose; ++round) {
    {
      const StageTimer timer(query.timings().forest_ms);
      places_.Match(pose->world_from_camera.Inverse(), features.ray,
                    features.found.descriptors, others,
                    {.radius = kSiftInlier_px * query.pixel(),
                     .max_squared_distance =
                         kMaxGuidedSiftDistance * kMaxGuidedSiftDistance},
                    features.match);
    }
    seen = Observe(features, query);
    pose = Refine(seen, pose->world_from_camera, query);
  }
  return pose;
}

absl::StatusOr<Candidate> SiftGenerator::Propose(
    Query& query, std::span<const Candidate> /*earlier*/) const {
  Features features = Extract(query);
  RayObservations seen;
  Candidate candidate;
  candidate.pose = SolveGuided(query, features, seen);
  TL_RETURN_IF_ERROR(query.CheckStop());
  if (!candidate.pose) {
    AskForest(1, options_.backtracking_leaves, query, features);
    TL_RETURN_IF_ERROR(query.CheckStop());
    seen = Observe(features, query);
    candidate.samples = static_cast<int>(seen.size());
    if (candidate.samples < kMinSiftMatches) return candidate;
    candidate.pose = Solve(seen, query);
    TL_RETURN_IF_ERROR(query.CheckStop());
  }
  candidate.samples = static_cast<int>(seen.size());
  candidate.reason = NotLocalizedReason::kTooFewInliers;
  candidate.is_matched = true;
  if (candidate.pose) {
    const image::ColorImage& picture = query.color();
    candidate.places =
        CountPlaces(seen, *candidate.pose,
                    kSameSiftPixel * std::max(picture.width, picture.height),
                    kEnoughSiftPlaces);
    candidate.focal =
        pose::EstimateFocal(seen.scene, candidate.pose->world_from_camera,
                            kSiftRobustScale_px * query.pixel());
    candidate.lens = LensOf(query, seen.scene, *candidate.pose,
                            kSiftRobustScale_px * query.pixel());
  }
  if (query.options().keep_correspondences) {
    candidate.correspondences = MatchesOf(seen, candidate.pose);
  }
  return candidate;
}

}  // namespace treeline::localizer
