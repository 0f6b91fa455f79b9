#include "server/core/localizer/rgb_localizer.h"

#include <optional>
#include <utility>

#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "server/core/localizer/forest_pnp.h"

namespace treeline::localizer {

RgbLocalizer::RgbLocalizer(std::unique_ptr<const forest::ModelFile> model,
                           PoseVerifier verifier, const QueryOptions& options)
    : model_(std::move(model)),
      verifier_(std::move(verifier)),
      options_(options) {}

absl::StatusOr<PoseEstimate> RgbLocalizer::Localize(
    const image::Frame& frame, const LocalizeOptions& options) const {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  const camera::Camera camera =
      frame.calibration.value_or(info().calibration).color;
  TL_RETURN_IF_ERROR(CheckColor(frame, camera));

  Pool<ForestScratch>::Lease lease(scratch_);
  ForestScratch& scratch = *lease;
  scratch.image.Assign(frame.color);
  PoseEstimate estimate;
  TL_ASSIGN_OR_RETURN(const ForestPnpResult found,
                      SolveForestPnp(model_->forest(), camera, options_,
                                     options, scratch, estimate));
  if (found.scene.size() > 0) {
    estimate.reason = NotLocalizedReason::kTooFewInliers;
  }
  if (found.pose) {
    TakePose(*found.pose, estimate);
    camera::RgbdCalibration calibration = info().calibration;
    calibration.color = camera;
    scratch.pyramid.Assign(scratch.image);
    verifier_.Judge(scratch.pyramid, nullptr, calibration, options, estimate);
  }
  if (options.keep_correspondences) {
    estimate.correspondences = CorrespondencesOf(found, scratch);
  }
  SetTotal(base::MillisecondsBetween(start, clock.Now()), estimate.timings);
  return estimate;
}

}  // namespace treeline::localizer
