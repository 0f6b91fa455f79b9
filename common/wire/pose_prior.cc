#include "common/wire/pose_prior.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/wire/geometry.h"

namespace treeline::wire {
namespace {

// Validate's message begins with the name of the field within `field`.
template <typename Prior>
absl::Status CheckPrior(const Prior& prior, absl::string_view field) {
  const absl::Status valid = prior.Validate();
  if (valid.ok()) return valid;
  return absl::InvalidArgumentError(absl::StrCat(field, ".", valid.message()));
}

absl::StatusOr<geometry::PosePrior> PoseFrom(const v1::PosePrior& proto,
                                             absl::string_view field) {
  geometry::PosePrior prior;
  TL_ASSIGN_OR_RETURN(prior.world_from_camera,
                      FromProto(proto.world_from_camera(),
                                absl::StrCat(field, ".world_from_camera")));
  prior.position_radius_m = proto.position_radius_m();
  prior.rotation_radius_rad = proto.rotation_radius_rad();
  TL_RETURN_IF_ERROR(CheckPrior(prior, field));
  return prior;
}

absl::StatusOr<geometry::PositionPrior> PositionFrom(
    const v1::PositionPrior& proto, absl::string_view field) {
  const std::string position = absl::StrCat(field, ".position_in_world_m");
  if (!proto.has_position_in_world_m()) return FieldError(position, "missing");
  geometry::PositionPrior prior;
  TL_ASSIGN_OR_RETURN(prior.position_in_world,
                      FromProto(proto.position_in_world_m(), position));
  prior.radius_m = proto.radius_m();
  TL_RETURN_IF_ERROR(CheckPrior(prior, field));
  return prior;
}

absl::StatusOr<geometry::HeightBand> HeightFrom(const v1::HeightBand& proto,
                                                absl::string_view field) {
  geometry::HeightBand band;
  if (proto.has_up_in_world()) {
    TL_ASSIGN_OR_RETURN(
        band.up_in_world,
        FromProto(proto.up_in_world(), absl::StrCat(field, ".up_in_world")));
  }
  band.min_m = proto.min_m();
  band.max_m = proto.max_m();
  TL_RETURN_IF_ERROR(CheckPrior(band, field));
  return band;
}

}  // namespace

void FillPriors(const geometry::PosePriors& priors,
                v1::LocalizeOptions& proto) {
  if (priors.pose) {
    v1::PosePrior& prior = *proto.mutable_prior();
    *prior.mutable_world_from_camera() =
        ToProto(priors.pose->world_from_camera);
    prior.set_position_radius_m(priors.pose->position_radius_m);
    prior.set_rotation_radius_rad(priors.pose->rotation_radius_rad);
  }
  if (priors.position) {
    v1::PositionPrior& prior = *proto.mutable_position_prior();
    *prior.mutable_position_in_world_m() =
        ToProto(priors.position->position_in_world);
    prior.set_radius_m(priors.position->radius_m);
  }
  if (priors.height) {
    v1::HeightBand& band = *proto.mutable_height_band();
    *band.mutable_up_in_world() = ToProto(priors.height->up_in_world);
    band.set_min_m(priors.height->min_m);
    band.set_max_m(priors.height->max_m);
  }
}

absl::StatusOr<geometry::PosePriors> PriorsFromProto(
    const v1::LocalizeOptions& proto, absl::string_view field) {
  geometry::PosePriors priors;
  if (proto.has_prior()) {
    TL_ASSIGN_OR_RETURN(priors.pose,
                        PoseFrom(proto.prior(), absl::StrCat(field, ".prior")));
  }
  if (proto.has_position_prior()) {
    TL_ASSIGN_OR_RETURN(priors.position,
                        PositionFrom(proto.position_prior(),
                                     absl::StrCat(field, ".position_prior")));
  }
  if (proto.has_height_band()) {
    TL_ASSIGN_OR_RETURN(
        priors.height,
        HeightFrom(proto.height_band(), absl::StrCat(field, ".height_band")));
  }
  return priors;
}

}  // namespace treeline::wire
