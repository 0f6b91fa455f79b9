#include "nav_agent/localization/odometry_buffer.h"

#include <algorithm>
#include <chrono>
#include <iterator>

#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "common/geometry/rigid2.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::localization {
namespace {

BufferedOdometry Between(const BufferedOdometry& a, const BufferedOdometry& b,
                         double t) {
  const auto mix = [t](double from, double to) {
    return from + t * (to - from);
  };
  const geometry::Rigid2& from = a.motion.odom_from_base;
  const geometry::Rigid2& to = b.motion.odom_from_base;
  BufferedOdometry moment = a;
  moment.motion.odom_from_base = {
      from.translation + t * (to.translation - from.translation),
      geometry::NormalizedAngle_rad(
          from.yaw_rad +
          t * geometry::NormalizedAngle_rad(to.yaw_rad - from.yaw_rad))};
  moment.motion.level_from_base =
      geometry::Slerp(a.motion.level_from_base, b.motion.level_from_base, t);
  moment.motion.forward_mps = mix(a.motion.forward_mps, b.motion.forward_mps);
  moment.motion.yaw_rate_radps =
      mix(a.motion.yaw_rate_radps, b.motion.yaw_rate_radps);
  moment.pitch_rad = mix(a.pitch_rad, b.pitch_rad);
  moment.roll_rad = mix(a.roll_rad, b.roll_rad);
  return moment;
}

}  // namespace

absl::Status OdometryBuffer::Add(const core::BaseReading& reading) {
  TL_RETURN_IF_ERROR(odometry_.Add(reading));
  const double share = moments_.empty() ? 1.0 : kTiltFilterShare.value;
  pitch_rad_ += share * (reading.pitch_rad - pitch_rad_);
  roll_rad_ += share * (reading.roll_rad - roll_rad_);
  moments_.push_back(
      {.motion = {.stamp = reading.stamp,
                  .odom_from_base = odometry_.PlanarOdomFromBase(),
                  .level_from_base = odometry_.LevelFromBase(),
                  .forward_mps = reading.forward_mps,
                  .yaw_rate_radps = reading.yaw_rate_radps},
       .pitch_rad = pitch_rad_,
       .roll_rad = roll_rad_});
  while (base::SecondsBetween(moments_.front().motion.stamp, reading.stamp) >
         kWheelMemory_s) {
    moments_.pop_front();
  }
  return absl::OkStatus();
}

std::optional<BufferedOdometry> OdometryBuffer::At(
    base::MonotonicTime stamp) const {
  if (moments_.empty() || stamp < moments_.front().motion.stamp) {
    return std::nullopt;
  }
  const auto after = std::ranges::lower_bound(
      moments_, stamp, {},
      [](const BufferedOdometry& moment) { return moment.motion.stamp; });
  if (after == moments_.end()) {
    return base::SecondsBetween(newest().motion.stamp, stamp) <= kMaxScanAhead_s
               ? std::optional(newest())
               : std::nullopt;
  }
  if (after == moments_.begin()) return *after;
  const auto before = std::prev(after);
  const double way_s =
      base::SecondsBetween(before->motion.stamp, after->motion.stamp);
  const double t =
      way_s > 0 ? base::SecondsBetween(before->motion.stamp, stamp) / way_s : 1;
  BufferedOdometry moment = Between(*before, *after, t);
  moment.motion.stamp = stamp;
  return moment;
}

}  // namespace treeline::localization
