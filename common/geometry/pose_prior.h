// What is known of a camera's pose before it is measured.
#ifndef COMMON_GEOMETRY_POSE_PRIOR_H_
#define COMMON_GEOMETRY_POSE_PRIOR_H_

#include "absl/status/status.h"
#include "common/geometry/rigid3.h"

namespace treeline::geometry {

// A pose, and how far the truth may be from it.
struct PosePrior {
  // Of the scene's pose sensor.
  Rigid3 world_from_camera;
  double position_radius_m = 0;    // positive
  double rotation_radius_rad = 0;  // in (0, pi]

  // INVALID_ARGUMENT names the field.
  absl::Status Validate() const;
};

}  // namespace treeline::geometry

#endif  // COMMON_GEOMETRY_POSE_PRIOR_H_
