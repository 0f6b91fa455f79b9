#include "server/core/localizer/pose_prior.h"

namespace treeline::localizer {

void ApplyPriors(const geometry::PosePriors& priors, PoseEstimate& estimate) {
  if (estimate.outcome != Outcome::kLocalized ||
      priors.Allows(estimate.world_from_camera)) {
    return;
  }
  estimate.outcome = Outcome::kNotLocalized;
  estimate.reason = NotLocalizedReason::kContradictsPrior;
}

}  // namespace treeline::localizer
