#include "server/core/localizer/forest_pnp.h"

#include <algorithm>

#include "common/base/clock.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"

namespace treeline::localizer {
namespace {

// Random streams of a query.
constexpr uint64_t kSampleStream = 1;
constexpr uint64_t kRansacStream = 2;

constexpr size_t kMinSamples = 30;

constexpr double kRansacInlier_px = 12;
constexpr double kRobustScale_px = 6;
constexpr double kInlier_px = 10;

}  // namespace

absl::StatusOr<ForestPnpResult> SolveForestPnp(
    const forest::ForestView& forest, const camera::Camera& camera,
    const QueryOptions& query_options, const LocalizeOptions& options,
    ForestScratch& scratch, PoseEstimate& estimate) {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  features::DrawPixels(camera, query_options.samples,
                       base::Random(options.seed, kSampleStream),
                       scratch.samples);
  const size_t samples = scratch.samples.size();
  estimate.samples = static_cast<int>(samples);
  estimate.timings.sample_ms = base::MillisecondsBetween(start, clock.Now());
  ForestPnpResult result;
  if (samples < kMinSamples) return result;

  const double pixel = 1 / camera::MeanFocal_px(camera);
  pose::PnpOptions ransac;
  ransac.seed = base::MixBits(options.seed + kRansacStream);
  ransac.hypotheses = query_options.hypotheses;
  ransac.inlier_distance = kRansacInlier_px * pixel;
  pose::PixelPredictions& scene = result.scene;
  scene.per_pixel = forest.trees();
  do {
    const base::MonotonicTime begin = clock.Now();
    const SampleBatch batch = NextBatch(query_options, scene.size(), samples);
    TL_RETURN_IF_ERROR(PredictScene(forest, query_options, batch, options.stop,
                                    scratch, scene.predictions));
    for (size_t i = batch.begin; i < batch.end; ++i) {
      const geometry::Vec3& ray = scratch.samples.point[i];
      scene.ray.push_back({ray.x, ray.y});
    }
    scene.ray_sigma.assign(scene.size(), pixel);
    estimate.timings.forest_ms += base::MillisecondsBetween(begin, clock.Now());
    const std::optional<geometry::Rigid3> pose =
        pose::PreemptivePnp(scene, ransac, options.stop);
    if (options.stop.stop_requested()) {
      return absl::CancelledError("the query was cancelled");
    }
    result.pose.reset();
    if (pose) {
      result.pose = pose::RefinePnp(scene, *pose,
                                    {.robust_scale = kRobustScale_px * pixel,
                                     .inlier_distance = kInlier_px * pixel});
    }
  } while (scene.size() < samples &&
           !(result.pose && IsSettled(query_options, result.pose->inliers)));
  estimate.samples = static_cast<int>(scene.size());
  return result;
}

void TakePose(const pose::PnpResult& pose, PoseEstimate& estimate) {
  estimate.inliers = pose.inliers;
  estimate.inlier_ratio = static_cast<double>(pose.inliers) / estimate.samples;
  estimate.world_from_camera = pose.world_from_camera;
  estimate.covariance = pose.covariance;
}

std::vector<Correspondence> CorrespondencesOf(const ForestPnpResult& result,
                                              const ForestScratch& scratch) {
  std::vector<Correspondence> correspondences;
  for (size_t i = 0; i < result.scene.size(); ++i) {
    const int8_t k = result.pose ? result.pose->supported[i] : int8_t{-1};
    correspondences.push_back(
        {{static_cast<double>(scratch.samples.x[i]),
          static_cast<double>(scratch.samples.y[i])},
         {},
         result.scene.at(i, std::max<int>(k, 0)).mean_in_world,
         k >= 0});
  }
  return correspondences;
}

}  // namespace treeline::localizer
