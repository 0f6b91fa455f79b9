// Poses, transforms, times and odometry.
//
// Within the bridge a MonotonicTime is ROS time: nanoseconds since 1970, or of
// a simulation's /clock, as the stamps of messages have it.
#ifndef COMMON_ROS2_CONVERSIONS_GEOMETRY_VALUES_H_
#define COMMON_ROS2_CONVERSIONS_GEOMETRY_VALUES_H_

#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/geometry/rigid3.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"

namespace treeline::conversions {

base::MonotonicTime TimeOf(const messages::Time& stamp);
messages::Time StampOf(base::MonotonicTime time);

// INVALID_ARGUMENT for what is not finite, or no rotation. A rotation of all
// zeros, which many drivers leave there, is none: the identity.
absl::StatusOr<geometry::Rigid3> RigidOf(const messages::Pose& pose);
absl::StatusOr<geometry::Rigid3> RigidOf(const messages::Transform& transform);
messages::Pose PoseOf(const geometry::Rigid3& transform);
messages::Transform TransformOf(const geometry::Rigid3& transform);

}  // namespace treeline::conversions

#endif  // COMMON_ROS2_CONVERSIONS_GEOMETRY_VALUES_H_
