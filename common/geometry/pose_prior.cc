#include "common/geometry/pose_prior.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"

namespace treeline::geometry {
namespace {

absl::Status CheckRadius(absl::string_view name, double radius_m) {
  if (radius_m > 0 && std::isfinite(radius_m)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      name, ": ", radius_m, " is not a positive number of metres"));
}

}  // namespace

absl::Status PosePrior::Validate() const {
  if (absl::Status radius = CheckRadius("position_radius_m", position_radius_m);
      !radius.ok()) {
    return radius;
  }
  if (!(rotation_radius_rad > 0 && rotation_radius_rad <= std::numbers::pi)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "rotation_radius_rad: ", rotation_radius_rad, " is not in (0, pi]"));
  }
  return absl::OkStatus();
}

bool PosePrior::Allows(const Rigid3& other_world_from_camera) const {
  const PoseError error =
      ErrorBetween(other_world_from_camera, world_from_camera);
  return error.translation_m <= position_radius_m &&
         error.rotation_rad <= rotation_radius_rad;
}

absl::Status PositionPrior::Validate() const {
  if (!IsFinite(position_in_world)) {
    return absl::InvalidArgumentError(
        "position_in_world_m: has a NaN or an infinity");
  }
  return CheckRadius("radius_m", radius_m);
}

bool PositionPrior::Allows(const Rigid3& world_from_camera) const {
  return Norm(world_from_camera.translation - position_in_world) <= radius_m;
}

absl::Status HeightBand::Validate() const {
  // Written so that NaN fails.
  if (!IsFinite(up_in_world) || !(Norm(up_in_world) > 0)) {
    return absl::InvalidArgumentError("up_in_world: is no direction");
  }
  if (!std::isfinite(min_m) || !std::isfinite(max_m) || !(min_m < max_m)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "max_m: ", min_m, " to ", max_m, " m is no band of heights"));
  }
  return absl::OkStatus();
}

bool HeightBand::Allows(const Rigid3& world_from_camera) const {
  const double height_m =
      Dot(Normalized(up_in_world), world_from_camera.translation);
  return height_m >= min_m && height_m <= max_m;
}

bool PosePriors::Allows(const Rigid3& world_from_camera) const {
  return (!pose || pose->Allows(world_from_camera)) &&
         (!position || position->Allows(world_from_camera)) &&
         (!height || height->Allows(world_from_camera));
}

PosePriors PosePriors::Widened(double by_m, double by_rad) const {
  PosePriors wide = *this;
  if (wide.pose) {
    wide.pose->position_radius_m += by_m;
    wide.pose->rotation_radius_rad =
        std::min(std::numbers::pi, wide.pose->rotation_radius_rad + by_rad);
  }
  if (wide.position) wide.position->radius_m += by_m;
  if (wide.height) {
    wide.height->min_m -= by_m;
    wide.height->max_m += by_m;
  }
  return wide;
}

}  // namespace treeline::geometry
