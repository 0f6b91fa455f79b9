#include "common/geometry/pose_prior.h"

#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"

namespace treeline::geometry {

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

}  // namespace treeline::geometry
