#include "nav_agent/ros_log/wheels_of_odometry.h"

#include <cmath>

namespace treeline::ros_log {

core::BaseReading WheelsOfOdometry::Add(
    base::MonotonicTime stamp, const geometry::Rigid2& odom_from_base) {
  core::BaseReading reading = last_;
  reading.stamp = stamp;
  reading.forward_mps = 0;
  reading.yaw_rate_radps = 0;
  if (last_odom_from_base_) {
    const geometry::Rigid2 last_from_base =
        last_odom_from_base_->Inverse() * odom_from_base;
    const double turn_rad = last_from_base.yaw_rad;
    const double half_rad = turn_rad / 2;
    // The chord of the arc lies in the direction of half the turn.
    const double chord_m = last_from_base.translation.x * std::cos(half_rad) +
                           last_from_base.translation.y * std::sin(half_rad);
    const double way_m = std::abs(half_rad) < 1e-9
                             ? chord_m
                             : chord_m * half_rad / std::sin(half_rad);
    reading.left_wheel_m += way_m - half_rad * wheel_track_m_;
    reading.right_wheel_m += way_m + half_rad * wheel_track_m_;
    const double interval_s = base::SecondsBetween(last_.stamp, stamp);
    if (interval_s > 0) {
      reading.forward_mps = way_m / interval_s;
      reading.yaw_rate_radps = turn_rad / interval_s;
    }
  }
  last_odom_from_base_ = odom_from_base;
  last_ = reading;
  return reading;
}

}  // namespace treeline::ros_log
