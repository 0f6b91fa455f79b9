#include "server/core/localizer/rgb_localizer.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "server/core/pose/pnp.h"

namespace treeline {
namespace {

// Random streams of a query.
constexpr uint64_t kSampleStream = 1;
constexpr uint64_t kRansacStream = 2;

constexpr int kMinSamples = 30;

}  // namespace

RgbLocalizer::RgbLocalizer(std::unique_ptr<const ModelFile> model,
                           PoseVerifier verifier, const QueryOptions& options)
    : model_(std::move(model)),
      verifier_(std::move(verifier)),
      options_(options) {}

absl::StatusOr<PoseEstimate> RgbLocalizer::Localize(
    const Frame& frame, const LocalizeOptions& options) const {
  const SteadyClock clock;
  const MonotonicTime start = clock.Now();
  const Camera camera = frame.calibration.value_or(info().calibration).color;
  TL_RETURN_IF_ERROR(CheckColor(frame, camera));

  Pool<ForestScratch>::Lease lease(scratch_);
  ForestScratch& scratch = *lease;
  scratch.image.Assign(frame.color);
  DrawPixels(camera, options_.samples, Random(options.seed, kSampleStream),
             scratch.samples);
  PoseEstimate estimate;
  estimate.samples = static_cast<int>(scratch.samples.size());
  const MonotonicTime sampled = clock.Now();
  estimate.timings.sample_ms = MillisecondsBetween(start, sampled);
  estimate.timings.total_ms = estimate.timings.sample_ms;
  if (estimate.samples < kMinSamples) return estimate;

  PixelPredictions scene;
  TL_RETURN_IF_ERROR(PredictScene(model_->forest(),
                                  options_.backtracking_leaves, options.stop,
                                  scratch, scene.predictions));
  scene.per_pixel = model_->forest().trees();
  for (const Vec3& ray : scratch.samples.point) {
    scene.ray.push_back({ray.x, ray.y});
  }
  const double pixel = 1 / MeanFocal_px(camera);
  scene.ray_sigma.assign(scene.size(), pixel);
  const MonotonicTime predicted = clock.Now();
  estimate.timings.forest_ms = MillisecondsBetween(sampled, predicted);

  PnpOptions ransac;
  ransac.seed = MixBits(options.seed + kRansacStream);
  ransac.hypotheses = options_.hypotheses;
  ransac.inlier_distance = 12 * pixel;
  PnpRefinementOptions refinement;
  refinement.robust_scale = 6 * pixel;
  refinement.inlier_distance = 10 * pixel;
  const std::optional<Rigid3> pose = PreemptivePnp(scene, ransac, options.stop);
  if (options.stop.stop_requested()) {
    return absl::CancelledError("the query was cancelled");
  }
  std::optional<PnpResult> refined;
  if (pose) refined = RefinePnp(scene, *pose, refinement);
  estimate.reason = NotLocalizedReason::kTooFewInliers;
  if (refined) {
    estimate.inliers = refined->inliers;
    estimate.inlier_ratio =
        static_cast<double>(refined->inliers) / estimate.samples;
    estimate.world_from_camera = refined->world_from_camera;
    estimate.covariance = refined->covariance;
    RgbdCalibration calibration = info().calibration;
    calibration.color = camera;
    scratch.pyramid.Assign(scratch.image);
    verifier_.Judge(scratch.pyramid, nullptr, calibration, estimate);
  }
  if (options.keep_correspondences) {
    for (size_t i = 0; i < scene.size(); ++i) {
      const int8_t k = refined ? refined->supported[i] : int8_t{-1};
      estimate.correspondences.push_back(
          {{static_cast<double>(scratch.samples.x[i]),
            static_cast<double>(scratch.samples.y[i])},
           {},
           scene.at(i, std::max<int>(k, 0)).mean_in_world,
           k >= 0});
    }
  }
  const MonotonicTime end = clock.Now();
  estimate.timings.pose_ms = MillisecondsBetween(predicted, end);
  estimate.timings.total_ms = MillisecondsBetween(start, end);
  return estimate;
}

}  // namespace treeline
