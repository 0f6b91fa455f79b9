#include "nav_agent/bridge/conversions/geometry_values.h"

#include <chrono>
#include <cmath>

#include "absl/status/status.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"

namespace treeline::conversions {
namespace {

absl::StatusOr<geometry::Rigid3> RigidFrom(const messages::Quaternion& q,
                                           geometry::Vec3 translation_m) {
  if (q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0) {
    return geometry::RigidFromQuaternion(1, 0, 0, 0, translation_m);
  }
  return geometry::RigidFromQuaternion(q.w, q.x, q.y, q.z, translation_m);
}

messages::Quaternion QuaternionOf(const geometry::Rotation3& rotation) {
  return {.x = rotation.x, .y = rotation.y, .z = rotation.z, .w = rotation.w};
}

}  // namespace

base::MonotonicTime TimeOf(const messages::Time& stamp) {
  return base::MonotonicTime(
      std::chrono::nanoseconds(messages::Nanoseconds(stamp)));
}

messages::Time StampOf(base::MonotonicTime time) {
  return messages::TimeOf(std::chrono::duration_cast<std::chrono::nanoseconds>(
                              time.time_since_epoch())
                              .count());
}

absl::StatusOr<geometry::Rigid3> RigidOf(const messages::Pose& pose) {
  return RigidFrom(pose.orientation,
                   {pose.position.x, pose.position.y, pose.position.z});
}

absl::StatusOr<geometry::Rigid3> RigidOf(const messages::Transform& transform) {
  const messages::Vector3& t = transform.translation;
  return RigidFrom(transform.rotation, {t.x, t.y, t.z});
}

messages::Pose PoseOf(const geometry::Rigid3& transform) {
  const geometry::Vec3& t = transform.translation;
  return {.position = {.x = t.x, .y = t.y, .z = t.z},
          .orientation = QuaternionOf(transform.rotation)};
}

messages::Transform TransformOf(const geometry::Rigid3& transform) {
  const geometry::Vec3& t = transform.translation;
  return {.translation = {.x = t.x, .y = t.y, .z = t.z},
          .rotation = QuaternionOf(transform.rotation)};
}

absl::StatusOr<core::BaseReading> WheelReadings::Add(
    const messages::Odometry& odometry) {
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 odom_from_base,
                      RigidOf(odometry.pose.pose));
  const messages::Twist& twist = odometry.twist.twist;
  if (!std::isfinite(twist.linear.x) || !std::isfinite(twist.angular.z)) {
    return absl::InvalidArgumentError("odometry: the twist is not finite");
  }
  if (has_last_) {
    const geometry::Rigid2 way =
        geometry::PlanarPose(odom_from_last_.Inverse() * odom_from_base);
    // Along the arc whose chord this is.
    const double half = way.yaw_rad / 2;
    const double stretch = std::abs(half) < 1e-6 ? 1 : half / std::sin(half);
    const double forward_m = stretch * (way.translation.x * std::cos(half) +
                                        way.translation.y * std::sin(half));
    left_m_ += forward_m - way.yaw_rad * wheel_track_m_ / 2;
    right_m_ += forward_m + way.yaw_rad * wheel_track_m_ / 2;
  }
  has_last_ = true;
  odom_from_last_ = odom_from_base;
  const geometry::Vec3 up =
      odom_from_base.rotation.Inverse() * geometry::Vec3{0, 0, 1};
  core::BaseReading reading;
  reading.stamp = TimeOf(odometry.header.stamp);
  reading.left_wheel_m = left_m_;
  reading.right_wheel_m = right_m_;
  reading.forward_mps = twist.linear.x;
  reading.yaw_rate_radps = twist.angular.z;
  reading.pitch_rad = std::atan2(-up.x, std::hypot(up.y, up.z));
  reading.roll_rad = std::atan2(up.y, up.z);
  reading.pitch_rate_radps = twist.angular.y;
  reading.roll_rate_radps = twist.angular.x;
  return reading;
}

}  // namespace treeline::conversions
