#include "server/core/localizer/rgbd_localizer.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "server/core/pose/preemptive_ransac.h"
#include "server/core/pose/rigid_refinement.h"

namespace treeline::localizer {
namespace {

// Random streams of a query.
constexpr uint64_t kSampleStream = 1;
constexpr uint64_t kRansacStream = 2;

// Below this many samples nothing can be said.
constexpr int kMinSamples = 30;

}  // namespace

RgbdLocalizer::RgbdLocalizer(std::unique_ptr<const forest::ModelFile> model,
                             PoseVerifier verifier, const QueryOptions& options)
    : model_(std::move(model)),
      verifier_(std::move(verifier)),
      options_(options) {}

absl::StatusOr<PoseEstimate> RgbdLocalizer::Localize(
    const image::Frame& frame, const LocalizeOptions& options) const {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  camera::RgbdCalibration calibration =
      frame.calibration.value_or(info().calibration);
  calibration.pose_sensor = info().calibration.pose_sensor;
  TL_RETURN_IF_ERROR(CheckColor(frame, calibration.color));
  TL_RETURN_IF_ERROR(CheckDepth(frame, calibration.depth, info().method));

  Pool<ForestScratch>::Lease lease(scratch_);
  ForestScratch& scratch = *lease;
  scratch.image.Assign(frame.color);
  features::DrawSamples(
      features::DepthGeometry(calibration), *frame.depth, options_.samples,
      base::Random(options.seed, kSampleStream), scratch.samples);
  PoseEstimate estimate;
  estimate.samples = static_cast<int>(scratch.samples.size());
  const base::MonotonicTime sampled = clock.Now();
  estimate.timings.sample_ms = base::MillisecondsBetween(start, sampled);
  estimate.timings.total_ms = estimate.timings.sample_ms;
  if (estimate.samples < kMinSamples) return estimate;

  const forest::ForestView& forest = model_->forest();
  pose::RansacOptions ransac_options;
  ransac_options.seed = base::MixBits(options.seed + kRansacStream);
  ransac_options.hypotheses = options_.hypotheses;
  pose::ScenePredictions scene;
  scene.per_point = forest.trees();
  std::optional<pose::RefinedPose> refined;
  do {
    const base::MonotonicTime begin = clock.Now();
    const SampleBatch batch =
        NextBatch(options_, scene.size(), scratch.samples.size());
    TL_RETURN_IF_ERROR(PredictScene(forest, options_, batch, options.stop,
                                    scratch, scene.predictions));
    for (size_t i = batch.begin; i < batch.end; ++i) {
      scene.point_in_camera.push_back(scratch.samples.point[i]);
      scene.depth_sigma_m.push_back(
          static_cast<double>(scratch.samples.depth_sigma_m[i]));
    }
    estimate.timings.forest_ms += base::MillisecondsBetween(begin, clock.Now());
    const std::optional<pose::RansacResult> ransac =
        pose::PreemptiveRansac(scene, ransac_options, options.stop);
    if (options.stop.stop_requested()) {
      return absl::CancelledError("the query was cancelled");
    }
    refined.reset();
    if (ransac)
      refined = pose::RefineRigid(scene, ransac->world_from_camera, {});
  } while (scene.size() < scratch.samples.size() &&
           !(refined && IsSettled(options_, refined->inliers)));
  estimate.samples = static_cast<int>(scene.size());
  estimate.reason = NotLocalizedReason::kTooFewInliers;
  if (refined) {
    estimate.inliers = refined->inliers;
    estimate.inlier_ratio =
        static_cast<double>(refined->inliers) / estimate.samples;
    estimate.world_from_camera = refined->world_from_camera;
    estimate.covariance = refined->covariance;
    scratch.pyramid.Assign(scratch.image);
    verifier_.Judge(scratch.pyramid, &*frame.depth, calibration, options,
                    estimate);
  }
  if (options.keep_correspondences) {
    for (size_t i = 0; i < scene.size(); ++i) {
      const int8_t k = refined ? refined->supported[i] : int8_t{-1};
      estimate.correspondences.push_back(
          {{static_cast<double>(scratch.samples.x[i]),
            static_cast<double>(scratch.samples.y[i])},
           scene.point_in_camera[i],
           scene.at(i, std::max<int>(k, 0)).mean_in_world,
           k >= 0});
    }
  }
  SetTotal(base::MillisecondsBetween(start, clock.Now()), estimate.timings);
  return estimate;
}

}  // namespace treeline::localizer
