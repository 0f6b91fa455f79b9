#include "server/core/localizer/color_ray_source.h"

#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "server/core/localizer/forest_prediction.h"
#include "server/core/pose/ray_refinement.h"

namespace treeline::localizer {

static_assert(PoseSource<ColorRaySource>);

absl::StatusOr<size_t> ColorRaySource::Observe(
    Query& query, std::span<const Candidate> /*earlier*/,
    RayObservations& seen) const {
  features::RgbdSamples& samples = query.scratch().samples;
  if (seen.size() == 0) {
    const StageTimer timer(query.timings().sample_ms);
    query.image();
    features::DrawPixels(query.camera(), options_.samples,
                         base::Random(query.seed(), kSampleStream), samples);
  }
  if (samples.size() < static_cast<size_t>(kMinSamples)) return samples.size();
  const StageTimer timer(query.timings().forest_ms);
  const SampleBatch batch = NextBatch(options_, seen.size(), samples.size());
  seen.scene.per_sample = forest_->trees();
  TL_RETURN_IF_ERROR(PredictScene(*forest_, options_, samples, batch, query,
                                  seen.scene.predictions));
  for (size_t i = batch.begin; i < batch.end; ++i) {
    seen.pixel.push_back(
        {static_cast<double>(samples.x[i]), static_cast<double>(samples.y[i])});
    const geometry::Vec3& ray = samples.point[i];
    seen.scene.ray.push_back({ray.x, ray.y});
  }
  seen.scene.ray_sigma.assign(seen.size(), query.pixel());
  return samples.size();
}

pose::RaySolver ColorRaySource::Solver(Query& query,
                                       const RayObservations& seen) const {
  return {seen.scene,
          {.inlier_distance = kForestRansacInlier_px * query.pixel()}};
}

std::optional<pose::RefinedPose> ColorRaySource::Refine(
    Query& query, const RayObservations& seen,
    const geometry::Rigid3& world_from_camera) const {
  return pose::RefineRays(
      seen.scene, world_from_camera,
      {.robust_scale = kForestRobustScale_px * query.pixel(),
       .inlier_distance = kForestInlier_px * query.pixel()});
}

}  // namespace treeline::localizer
