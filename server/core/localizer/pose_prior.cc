#include "server/core/localizer/pose_prior.h"

namespace treeline::localizer {

void ApplyPrior(const geometry::PosePrior& prior, PoseEstimate& estimate) {
  if (estimate.outcome != Outcome::kLocalized) return;
  const geometry::Rigid3& found = estimate.world_from_camera;
  const double distance_m =
      geometry::Norm(found.translation - prior.world_from_camera.translation);
  const double angle_rad = geometry::AngleBetween_rad(
      found.rotation, prior.world_from_camera.rotation);
  if (distance_m <= prior.position_radius_m &&
      angle_rad <= prior.rotation_radius_rad) {
    return;
  }
  estimate.outcome = Outcome::kNotLocalized;
  estimate.reason = NotLocalizedReason::kContradictsPrior;
}

}  // namespace treeline::localizer
