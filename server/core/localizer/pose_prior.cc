#include "server/core/localizer/pose_prior.h"

#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"

namespace treeline::localizer {

absl::Status PosePrior::Validate() const {
  if (!(position_radius_m > 0) || !std::isfinite(position_radius_m)) {
    return absl::InvalidArgumentError(
        absl::StrCat("position_radius_m: ", position_radius_m,
                     " is not a positive number of metres"));
  }
  if (!(rotation_radius_rad > 0 && rotation_radius_rad <= std::numbers::pi)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "rotation_radius_rad: ", rotation_radius_rad, " is not in (0, pi]"));
  }
  return absl::OkStatus();
}

void ApplyPrior(const PosePrior& prior, PoseEstimate& estimate) {
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
