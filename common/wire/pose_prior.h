// What a client knows of its pose, proto <-> C++.
#ifndef COMMON_WIRE_POSE_PRIOR_H_
#define COMMON_WIRE_POSE_PRIOR_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/pose_prior.h"
#include "treeline/v1/relocalization.pb.h"

namespace treeline::wire {

void FillPriors(const geometry::PosePriors& priors, v1::LocalizeOptions& proto);

// INVALID_ARGUMENT naming the field of `field`, whose message this is.
absl::StatusOr<geometry::PosePriors> PriorsFromProto(
    const v1::LocalizeOptions& proto, absl::string_view field);

}  // namespace treeline::wire

#endif  // COMMON_WIRE_POSE_PRIOR_H_
