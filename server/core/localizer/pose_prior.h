// What a client knows about its pose before it asks.
#ifndef SERVER_CORE_LOCALIZER_POSE_PRIOR_H_
#define SERVER_CORE_LOCALIZER_POSE_PRIOR_H_

#include "absl/status/status.h"
#include "common/geometry/rigid3.h"
#include "server/core/localizer/localizer.h"

namespace treeline::localizer {

// A pose, and how far the truth may be from it.
struct PosePrior {
  // Of the scene's pose sensor.
  geometry::Rigid3 world_from_camera;
  double position_radius_m = 0;    // positive
  double rotation_radius_rad = 0;  // in (0, pi]

  absl::Status Validate() const;
};

// Withdraws a pose that the prior rules out: it becomes kNotLocalized with
// reason kContradictsPrior; its evidence stays. The prior never makes a pose
// more probable, so that a wrong one can hide an answer but not forge one.
void ApplyPrior(const PosePrior& prior, PoseEstimate& estimate);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_POSE_PRIOR_H_
