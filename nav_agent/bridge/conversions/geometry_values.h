// Poses, transforms, times and odometry.
//
// Within the bridge a MonotonicTime is ROS time: nanoseconds since 1970, or of
// a simulation's /clock, as the stamps of messages have it.
#ifndef NAV_AGENT_BRIDGE_CONVERSIONS_GEOMETRY_VALUES_H_
#define NAV_AGENT_BRIDGE_CONVERSIONS_GEOMETRY_VALUES_H_

#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/bridge/messages/common_messages.h"
#include "nav_agent/bridge/messages/geometry_messages.h"
#include "nav_agent/bridge/messages/nav_messages.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::conversions {

base::MonotonicTime TimeOf(const messages::Time& stamp);
messages::Time StampOf(base::MonotonicTime time);

// INVALID_ARGUMENT for what is not finite, or no rotation. A rotation of all
// zeros, which many drivers leave there, is none: the identity.
absl::StatusOr<geometry::Rigid3> RigidOf(const messages::Pose& pose);
absl::StatusOr<geometry::Rigid3> RigidOf(const messages::Transform& transform);
messages::Pose PoseOf(const geometry::Rigid3& transform);
messages::Transform TransformOf(const geometry::Rigid3& transform);

// nav_msgs/Odometry as wheels of a differential drive with such a track would
// have rolled: by the way between two messages. Not thread-safe.
class WheelReadings {
 public:
  explicit WheelReadings(double wheel_track_m)
      : wheel_track_m_(wheel_track_m) {}

  // INVALID_ARGUMENT for numbers that are none; then nothing has changed.
  absl::StatusOr<core::BaseReading> Add(const messages::Odometry& odometry);

 private:
  double wheel_track_m_;
  bool has_last_ = false;
  geometry::Rigid3 odom_from_last_;
  double left_m_ = 0;
  double right_m_ = 0;
};

}  // namespace treeline::conversions

#endif  // NAV_AGENT_BRIDGE_CONVERSIONS_GEOMETRY_VALUES_H_
