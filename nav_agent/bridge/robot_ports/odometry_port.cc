#include "nav_agent/bridge/robot_ports/odometry_port.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "common/ros2/conversions/geometry_values.h"

namespace treeline::robot_ports {
namespace {

constexpr auto kRemembered = std::chrono::seconds(2);
// Older than the newest by more: the stamps' clock was set back, and is known
// to be (RosTime), or the odometry's own begins anew.
constexpr auto kNewClock = std::chrono::seconds(1);
// No robot on wheels indoors is faster, or turns faster.
constexpr double kFastest_mps = 5;
constexpr double kFastest_radps = 10;
// Poses of two messages may differ by rounding and by late stamps, too.
constexpr double kSlack_m = 0.1;
constexpr double kSlack_rad = 0.2;

struct Tilt {
  double pitch_rad = 0;
  double roll_rad = 0;
};

// Of Rz(yaw) Ry(pitch) Rx(roll) (REP 103).
Tilt TiltOf(const geometry::Rotation3& odom_from_base) {
  const geometry::Vec3 forward = odom_from_base * geometry::Vec3{1, 0, 0};
  const geometry::Vec3 left = odom_from_base * geometry::Vec3{0, 1, 0};
  const geometry::Vec3 up = odom_from_base * geometry::Vec3{0, 0, 1};
  return {.pitch_rad = std::asin(std::clamp(-forward.z, -1.0, 1.0)),
          .roll_rad = std::atan2(left.z, up.z)};
}

geometry::Rigid3 Between(const geometry::Rigid3& a, const geometry::Rigid3& b,
                         double part) {
  // Turned about z alone: what changes within 20 ms of pitch is nothing.
  const double turn_rad = geometry::NormalizedAngle_rad(
      geometry::Yaw_rad(b.rotation) - geometry::Yaw_rad(a.rotation));
  return {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, part * turn_rad}) *
                  a.rotation,
      .translation = a.translation + part * (b.translation - a.translation)};
}

}  // namespace

absl::Status OdometryPort::Refuse(const absl::Status& why) {
  const absl::MutexLock lock(&mutex_);
  return health_.NoteBroken(why);
}

absl::Status OdometryPort::Add(const messages::Odometry& message,
                               const geometry::Rigid3& child_from_base) {
  const absl::StatusOr<geometry::Rigid3> odom_from_child =
      conversions::RigidOf(message.pose.pose);
  const messages::Twist& twist = message.twist.twist;
  const double yaw_rate_radps = twist.angular.z;
  // Of the base's point, in the direction of its x axis.
  const geometry::Vec3 at = child_from_base.translation;
  const geometry::Vec3 velocity =
      child_from_base.rotation.Inverse() *
      geometry::Vec3{twist.linear.x - yaw_rate_radps * at.y,
                     twist.linear.y + yaw_rate_radps * at.x, 0};
  const absl::Status stamped = time_.CheckStamp(message.header.stamp);
  const absl::MutexLock lock(&mutex_);
  if (!odom_from_child.ok())
    return health_.NoteBroken(odom_from_child.status());
  if (!stamped.ok()) return health_.NoteBroken(stamped);
  if (!(std::abs(velocity.x) <= kFastest_mps) ||
      !(std::abs(yaw_rate_radps) <= kFastest_radps)) {
    return health_.NoteBroken(absl::InvalidArgumentError(
        absl::StrCat("odometry of ", twist.linear.x, " m/s and ",
                     yaw_rate_radps, " rad/s: that is no robot's")));
  }
  const Moment moment = {.stamp = time_.TimeOf(message.header.stamp),
                         .odom_from_base = *odom_from_child * child_from_base};
  if (!trail_.empty()) {
    const Moment& last = trail_.back();
    if (moment.stamp <= last.stamp && last.stamp - moment.stamp < kNewClock) {
      return health_.NoteBroken(absl::InvalidArgumentError(
          "odometry that is no newer than that before it"));
    }
    if (moment.stamp <= last.stamp) {
      trail_.clear();
    } else {
      TurnWheels(last, moment);
    }
  }
  trail_.push_back(moment);
  while (trail_.front().stamp < moment.stamp - kRemembered) trail_.pop_front();
  frame_id_ = message.header.frame_id;
  health_.NoteGood(real_clock_.Now());
  const Tilt tilt = TiltOf(moment.odom_from_base.rotation);
  core::BaseReading reading;
  reading.stamp = moment.stamp;
  reading.left_wheel_m = left_wheel_m_;
  reading.right_wheel_m = right_wheel_m_;
  reading.forward_mps = velocity.x;
  reading.yaw_rate_radps = yaw_rate_radps;
  reading.pitch_rad = tilt.pitch_rad;
  reading.roll_rad = tilt.roll_rad;
  reading.pitch_rate_radps =
      std::isfinite(twist.angular.y) ? twist.angular.y : 0;
  reading.roll_rate_radps =
      std::isfinite(twist.angular.x) ? twist.angular.x : 0;
  waiting_.Add(reading, health_);
  return absl::OkStatus();
}

void OdometryPort::TurnWheels(const Moment& from, const Moment& to) {
  const double passed_s = base::SecondsBetween(from.stamp, to.stamp);
  const geometry::Vec3 way =
      to.odom_from_base.translation - from.odom_from_base.translation;
  const double turn_rad = geometry::NormalizedAngle_rad(
      geometry::Yaw_rad(to.odom_from_base.rotation) -
      geometry::Yaw_rad(from.odom_from_base.rotation));
  const double way_m = std::hypot(way.x, way.y, way.z);
  if (way_m > kFastest_mps * passed_s + kSlack_m ||
      std::abs(turn_rad) > kFastest_radps * passed_s + kSlack_rad) {
    ++leaps_;
    trail_.clear();
    return;
  }
  // The chord of an arc has the direction of its middle.
  const geometry::Rigid3 middle =
      Between(from.odom_from_base, to.odom_from_base, 0.5);
  const double forward_m = (middle.rotation.Inverse() * way).x;
  const double half_m = turn_rad * wheel_track_m_ / 2;
  left_wheel_m_ += forward_m - half_m;
  right_wheel_m_ += forward_m + half_m;
}

std::optional<geometry::Rigid3> OdometryPort::OdomFromBaseAt(
    base::MonotonicTime stamp) const {
  const absl::MutexLock lock(&mutex_);
  if (trail_.empty() || stamp < trail_.front().stamp) return std::nullopt;
  const auto after =
      std::ranges::lower_bound(trail_, stamp, {}, &Moment::stamp);
  if (after == trail_.end()) return trail_.back().odom_from_base;
  if (after->stamp == stamp) return after->odom_from_base;
  const Moment& before = *(after - 1);
  return Between(before.odom_from_base, after->odom_from_base,
                 base::SecondsBetween(before.stamp, stamp) /
                     base::SecondsBetween(before.stamp, after->stamp));
}

std::string OdometryPort::frame_id() const {
  const absl::MutexLock lock(&mutex_);
  return frame_id_;
}

int64_t OdometryPort::leaps() const {
  const absl::MutexLock lock(&mutex_);
  return leaps_;
}

std::vector<core::BaseReading> OdometryPort::TakeReadings() {
  const absl::MutexLock lock(&mutex_);
  return waiting_.Take();
}

core::DeviceHealth OdometryPort::Health() const {
  const absl::MutexLock lock(&mutex_);
  return health_.At(real_clock_.Now());
}

}  // namespace treeline::robot_ports
