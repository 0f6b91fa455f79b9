// Wheel readings from the poses that another system's odometry tells.
#ifndef NAV_AGENT_ROS_LOG_WHEELS_OF_ODOMETRY_H_
#define NAV_AGENT_ROS_LOG_WHEELS_OF_ODOMETRY_H_

#include <optional>

#include "common/base/clock.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::ros_log {

// How the two wheels of a differential drive rolled between poses, along arcs:
// integrated again they give the poses back, but for sideways motion, which
// such wheels do not tell. Not thread-safe.
class WheelsOfOdometry {
 public:
  explicit WheelsOfOdometry(double wheel_track_m)
      : wheel_track_m_(wheel_track_m) {}

  // Speeds are those since the pose before.
  core::BaseReading Add(base::MonotonicTime stamp,
                        const geometry::Rigid2& odom_from_base);

 private:
  const double wheel_track_m_;
  std::optional<geometry::Rigid2> last_odom_from_base_;
  core::BaseReading last_;
};

}  // namespace treeline::ros_log

#endif  // NAV_AGENT_ROS_LOG_WHEELS_OF_ODOMETRY_H_
