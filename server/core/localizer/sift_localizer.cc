#include "server/core/localizer/sift_localizer.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "absl/memory/memory.h"
#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "server/core/localizer/forest_query.h"
#include "server/core/localizer/pose_verifier.h"

namespace treeline::localizer {
namespace {

// The random stream of a query.
constexpr uint64_t kRansacStream = 2;

// A match is kept if its descriptor distance is below this times that of the
// best mode elsewhere in the scene (Lowe's ratio test).
constexpr double kMatchRatio = 0.85;
// Elsewhere is further than this from the match, in viewing distances.
constexpr double kSamePlace = 0.02;
// With fewer matches there is nothing to say.
constexpr int kMinMatches = 8;
// An answer needs this many inliers.
constexpr int kMinInliers = 12;
constexpr int kFewMatches = 30;
// ... and a position that they determine this well, in viewing distances.
constexpr double kMaxPositionSigma = 0.05;

constexpr double kKeypointSigma_px = 1;
constexpr double kRansacInlier_px = 6;
constexpr double kRobustScale_px = 4;
constexpr double kInlier_px = 4;

}  // namespace

struct SiftLocalizer::Matches {
  std::vector<camera::Pixel> pixel;
  pose::PixelPredictions scene;
};

absl::StatusOr<std::unique_ptr<SiftLocalizer>> SiftLocalizer::Create(
    std::unique_ptr<const forest::ModelFile> model,
    const QueryOptions& options) {
  if (model->forest().sift_descriptors.empty() ||
      !(model->info().viewing_distance > 0)) {
    return absl::DataLossError(
        "corrupt model: method sift without SIFT descriptors or without a "
        "viewing distance");
  }
  return absl::WrapUnique(new SiftLocalizer(std::move(model), options));
}

SiftLocalizer::SiftLocalizer(std::unique_ptr<const forest::ModelFile> model,
                             const QueryOptions& options)
    : model_(std::move(model)), options_(options) {}

absl::StatusOr<SiftLocalizer::Matches> SiftLocalizer::Match(
    const features::SiftFeatures& features, const camera::Camera& camera,
    const std::stop_token& stop) const {
  const forest::ForestView& forest = model_->forest();
  std::vector<forest::SiftMatch> found(features.size());
  forest::MatchSift(forest, features.descriptors,
                    {.leaves_per_tree = options_.backtracking_leaves,
                     .same_place = kSamePlace * info().viewing_distance},
                    stop, found);
  if (stop.stop_requested()) {
    return absl::CancelledError("the query was cancelled");
  }
  // Squared ratios of distances: what is least like anything else is surest.
  std::vector<double> ratio(found.size());
  std::vector<size_t> kept;
  std::vector<camera::Pixel> rays(found.size());
  for (size_t i = 0; i < found.size(); ++i) {
    if (found[i].mode == forest::kNoLeaf) continue;
    ratio[i] = static_cast<double>(found[i].distance) /
               std::max(1, found[i].distance_elsewhere);
    if (!(ratio[i] < kMatchRatio * kMatchRatio)) continue;
    const std::optional<camera::Pixel> ray =
        camera.Unproject(features.keypoints[i].pixel);
    if (!ray) continue;
    rays[i] = *ray;
    kept.push_back(i);
  }
  std::ranges::stable_sort(kept, {}, [&](size_t i) { return ratio[i]; });
  Matches matches;
  matches.scene.per_pixel = 1;
  for (const size_t i : kept) {
    matches.pixel.push_back(features.keypoints[i].pixel);
    matches.scene.ray.push_back(rays[i]);
    // The points' uncertainties are left out: points and poses were fitted to
    // each other by plain reprojection errors, and answers that weigh them
    // otherwise agree less with it (docs/structure-from-motion.md).
    matches.scene.predictions.push_back(
        {.mean_in_world = forest.LeafMean(found[i].mode), .covariance = {}});
  }
  matches.scene.ray_sigma.assign(
      kept.size(), kKeypointSigma_px / camera::MeanFocal_px(camera));
  return matches;
}

absl::Status SiftLocalizer::Solve(const Matches& matches,
                                  const camera::Camera& camera,
                                  const LocalizeOptions& options,
                                  PoseEstimate& estimate) const {
  const double pixel = 1 / camera::MeanFocal_px(camera);
  pose::PnpOptions ransac;
  ransac.seed = base::MixBits(options.seed + kRansacStream);
  ransac.hypotheses = options_.hypotheses;
  ransac.inlier_distance = kRansacInlier_px * pixel;
  const std::optional<geometry::Rigid3> pose =
      pose::PreemptivePnp(matches.scene, ransac, options.stop);
  if (options.stop.stop_requested()) {
    return absl::CancelledError("the query was cancelled");
  }
  std::optional<pose::PnpResult> refined;
  if (pose) {
    refined = pose::RefinePnp(matches.scene, *pose,
                              {.robust_scale = kRobustScale_px * pixel,
                               .inlier_distance = kInlier_px * pixel});
  }
  estimate.reason = NotLocalizedReason::kTooFewInliers;
  if (refined) {
    estimate.inliers = refined->inliers;
    estimate.inlier_ratio =
        static_cast<double>(refined->inliers) / estimate.samples;
    estimate.world_from_camera = refined->world_from_camera;
    estimate.covariance = refined->covariance;
    // A share of few matches means little.
    estimate.evidence.inlier_ratio = static_cast<double>(refined->inliers) /
                                     (estimate.samples + kFewMatches);
    const forest::ConfidenceModel confidence =
        info().confidence.value_or(forest::ConfidenceModel::WithoutKeyframes());
    estimate.confidence = confidence.Probability(estimate.evidence);
    if (estimate.inliers >= kMinInliers) {
      const bool is_determined = PositionSigma_m(refined->covariance) <=
                                 kMaxPositionSigma * info().viewing_distance;
      if (!is_determined) {
        estimate.reason = NotLocalizedReason::kPoorlyConstrained;
      } else if (estimate.confidence <
                 options.min_confidence.value_or(confidence.threshold)) {
        estimate.reason = NotLocalizedReason::kLowConfidence;
      } else {
        estimate.reason = NotLocalizedReason::kNone;
        estimate.outcome = Outcome::kLocalized;
      }
    }
  }
  if (!options.keep_correspondences) return absl::OkStatus();
  const geometry::Rigid3 camera_from_world =
      estimate.world_from_camera.Inverse();
  for (size_t i = 0; i < matches.pixel.size(); ++i) {
    const geometry::Vec3 in_world = matches.scene.at(i, 0).mean_in_world;
    estimate.correspondences.push_back(
        {matches.pixel[i],
         refined ? camera_from_world * in_world : geometry::Vec3{}, in_world,
         refined && refined->supported[i] >= 0});
  }
  return absl::OkStatus();
}

absl::StatusOr<PoseEstimate> SiftLocalizer::Localize(
    const image::Frame& frame, const LocalizeOptions& options) const {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  const camera::Camera camera =
      frame.calibration.value_or(info().calibration).color;
  TL_RETURN_IF_ERROR(CheckColor(frame, camera));
  TL_ASSIGN_OR_RETURN(
      const features::SiftFeatures features,
      features::ExtractSift(frame.color, {.max_features = options_.features}));
  PoseEstimate estimate;
  const base::MonotonicTime extracted = clock.Now();
  estimate.timings.sample_ms = base::MillisecondsBetween(start, extracted);
  TL_ASSIGN_OR_RETURN(const Matches matches,
                      Match(features, camera, options.stop));
  const base::MonotonicTime matched = clock.Now();
  estimate.timings.forest_ms = base::MillisecondsBetween(extracted, matched);
  estimate.samples = static_cast<int>(matches.pixel.size());
  if (estimate.samples >= kMinMatches) {
    TL_RETURN_IF_ERROR(Solve(matches, camera, options, estimate));
  }
  const base::MonotonicTime end = clock.Now();
  estimate.timings.pose_ms = base::MillisecondsBetween(matched, end);
  estimate.timings.total_ms = base::MillisecondsBetween(start, end);
  return estimate;
}

}  // namespace treeline::localizer
