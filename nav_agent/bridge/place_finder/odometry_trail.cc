#include "nav_agent/bridge/place_finder/odometry_trail.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "common/ros2/conversions/geometry_values.h"

namespace treeline::place_finder {
namespace {

constexpr auto kRemembered = std::chrono::seconds(10);
constexpr auto kNewClock = std::chrono::seconds(1);
constexpr auto kAhead = std::chrono::milliseconds(100);

// Pitch and roll alone.
geometry::Rotation3 LevelFromBase(const geometry::Rotation3& odom_from_base) {
  return geometry::Rotation3::FromAxisAngle(
             {0, 0, -geometry::Yaw_rad(odom_from_base)}) *
         odom_from_base;
}

}  // namespace

absl::Status OdometryTrail::Add(const messages::Odometry& odometry) {
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 odom_from_base,
                      conversions::RigidOf(odometry.pose.pose));
  const double forward_mps = odometry.twist.twist.linear.x;
  const double yaw_rate_radps = odometry.twist.twist.angular.z;
  if (!std::isfinite(forward_mps) || !std::isfinite(yaw_rate_radps)) {
    return absl::InvalidArgumentError("odometry: the twist is not finite");
  }
  const base::MonotonicTime stamp = conversions::TimeOf(odometry.header.stamp);
  if (!moments_.empty() && stamp <= moments_.back().stamp) {
    if (moments_.back().stamp - stamp < kNewClock) return absl::OkStatus();
    moments_.clear();
    ++restarts_;
  }
  frame_ = odometry.header.frame_id;
  moments_.push_back({.stamp = stamp,
                      .odom_from_base = geometry::PlanarPose(odom_from_base),
                      .level_from_base = LevelFromBase(odom_from_base.rotation),
                      .forward_mps = forward_mps,
                      .yaw_rate_radps = yaw_rate_radps});
  while (moments_.front().stamp < stamp - kRemembered) moments_.pop_front();
  return absl::OkStatus();
}

std::optional<localization::TrackedMotion> OdometryTrail::At(
    base::MonotonicTime stamp) const {
  if (moments_.empty() || stamp < moments_.front().stamp ||
      stamp > moments_.back().stamp + kAhead) {
    return std::nullopt;
  }
  const auto after = std::ranges::lower_bound(
      moments_, stamp, {}, &localization::TrackedMotion::stamp);
  if (after == moments_.end()) return moments_.back();
  if (after->stamp == stamp) return *after;
  const localization::TrackedMotion& before = *(after - 1);
  const double part = base::SecondsBetween(before.stamp, stamp) /
                      base::SecondsBetween(before.stamp, after->stamp);
  const geometry::Rigid2& a = before.odom_from_base;
  const geometry::Rigid2& b = after->odom_from_base;
  localization::TrackedMotion between = before;
  between.stamp = stamp;
  between.odom_from_base = {
      a.translation + part * (b.translation - a.translation),
      geometry::NormalizedAngle_rad(
          a.yaw_rad +
          part * geometry::NormalizedAngle_rad(b.yaw_rad - a.yaw_rad))};
  return between;
}

}  // namespace treeline::place_finder
