#include "server/core/localizer/depth_point_source.h"

#include <algorithm>

#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "server/core/localizer/forest_prediction.h"
#include "server/core/pose/point_refinement.h"

namespace treeline::localizer {

static_assert(PoseSource<DepthPointSource>);

absl::StatusOr<size_t> DepthPointSource::Observe(
    Query& query, std::span<const Candidate> /*earlier*/,
    PointObservations& seen) const {
  if (query.depth() == nullptr) return 0;
  features::RgbdSamples& samples = query.scratch().samples;
  // Most queries need no more than the first.
  const bool is_first = seen.size() == 0;
  const int wanted = is_first
                         ? std::min(options_.first_samples, options_.samples)
                         : options_.samples;
  {
    const StageTimer timer(query.timings().sample_ms);
    query.image();
    features::DrawFirstSamples(
        features::DepthGeometry(query.calibration()), *query.depth(), wanted,
        options_.samples, base::Random(query.seed(), kSampleStream), samples);
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
    seen.scene.point_in_camera.push_back(samples.point[i]);
    seen.scene.depth_sigma_m.push_back(
        static_cast<double>(samples.depth_sigma_m[i]));
  }
  // Where the first are there, more may be.
  return is_first && samples.size() == static_cast<size_t>(wanted)
             ? static_cast<size_t>(options_.samples)
             : samples.size();
}

pose::PointSolver DepthPointSource::Solver(
    Query& /*query*/, const PointObservations& seen) const {
  return {seen.scene, {}};
}

std::optional<pose::RefinedPose> DepthPointSource::Refine(
    Query& /*query*/, const PointObservations& seen,
    const geometry::Rigid3& world_from_camera) const {
  return pose::RefinePoints(seen.scene, world_from_camera, {});
}

std::optional<pose::FocalEstimate> DepthPointSource::Focal(
    Query& query, const PointObservations& seen,
    const pose::RefinedPose& pose) const {
  const camera::RgbdCalibration& calibration = query.calibration();
  if (!(calibration.depth == calibration.color)) return std::nullopt;
  return pose::EstimateFocal(seen.scene, pose.world_from_camera);
}

}  // namespace treeline::localizer
