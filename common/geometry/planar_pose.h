// A pose in space, seen from above.
#ifndef COMMON_GEOMETRY_PLANAR_POSE_H_
#define COMMON_GEOMETRY_PLANAR_POSE_H_

#include <cmath>

#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "common/geometry/vector3.h"

namespace treeline::geometry {

// The heading of the child's x axis, projected onto the parent's x-y plane
// (rad, counter-clockwise from the parent's x axis).
inline double Yaw_rad(const Rotation3& parent_from_child) {
  const Vec3 forward = parent_from_child * Vec3{1, 0, 0};
  return std::atan2(forward.y, forward.x);
}

// x, y and yaw of a pose; height, pitch and roll are left out.
inline Rigid2 PlanarPose(const Rigid3& parent_from_child) {
  return {{parent_from_child.translation.x, parent_from_child.translation.y},
          Yaw_rad(parent_from_child.rotation)};
}

}  // namespace treeline::geometry

#endif  // COMMON_GEOMETRY_PLANAR_POSE_H_
