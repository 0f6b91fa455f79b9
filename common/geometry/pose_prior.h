// What is known of a camera's pose before it is measured.
#ifndef COMMON_GEOMETRY_POSE_PRIOR_H_
#define COMMON_GEOMETRY_POSE_PRIOR_H_

#include <optional>

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
  bool Allows(const Rigid3& world_from_camera) const;
};

// A place, whatever the rotation.
struct PositionPrior {
  Vec3 position_in_world;
  double radius_m = 0;  // positive

  absl::Status Validate() const;
  bool Allows(const Rigid3& world_from_camera) const;
};

// Heights along a direction, from the world's origin.
struct HeightBand {
  // Any length but zero.
  Vec3 up_in_world{0, 0, 1};
  double min_m = 0;
  double max_m = 0;  // more than min_m

  absl::Status Validate() const;
  bool Allows(const Rigid3& world_from_camera) const;
};

// All that is believed; a pose has to agree with each.
struct PosePriors {
  std::optional<PosePrior> pose = std::nullopt;
  std::optional<PositionPrior> position = std::nullopt;
  std::optional<HeightBand> height = std::nullopt;

  // Whether nothing is known.
  bool empty() const { return !pose && !position && !height; }
  bool Allows(const Rigid3& world_from_camera) const;
  // What is allowed of poses that are up to so far from one that is.
  PosePriors Widened(double by_m, double by_rad) const;
};

}  // namespace treeline::geometry

#endif  // COMMON_GEOMETRY_POSE_PRIOR_H_
