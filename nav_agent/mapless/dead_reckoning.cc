#include "nav_agent/mapless/dead_reckoning.h"

#include <cmath>

namespace treeline::mapless {
namespace {

constexpr double kRemembered_s = 0.5;
constexpr double kMaxAhead_s = 0.1;
// Wheels do not roll so far between two readings.
constexpr double kMaxStep_m = 0.5;

}  // namespace

geometry::Rigid2 MovedOn(const geometry::Rigid2& from, double forward_mps,
                         double yaw_rate_radps, double duration_s) {
  const double turn_rad = yaw_rate_radps * duration_s;
  const double way_m = forward_mps * duration_s;
  const double middle_rad = from.yaw_rad + 0.5 * turn_rad;
  return {{from.translation.x + way_m * std::cos(middle_rad),
           from.translation.y + way_m * std::sin(middle_rad)},
          geometry::NormalizedAngle_rad(from.yaw_rad + turn_rad)};
}

void DeadReckoning::Add(const core::BaseReading& reading) {
  if (!last_.has_value()) {
    last_ = reading;
    entries_.push_back({reading.stamp, {}});
    return;
  }
  const double dt_s = base::SecondsBetween(last_->stamp, reading.stamp);
  if (dt_s <= 0) return;
  double way_m = 0.5 * (reading.left_wheel_m - last_->left_wheel_m +
                        reading.right_wheel_m - last_->right_wheel_m);
  if (std::abs(way_m) > kMaxStep_m) way_m = 0;
  const double yaw_rate_radps =
      0.5 * (reading.yaw_rate_radps + last_->yaw_rate_radps);
  entries_.push_back(
      {reading.stamp, MovedOn(entries_.back().odom_from_base, way_m / dt_s,
                              yaw_rate_radps, dt_s)});
  last_ = reading;
  while (entries_.size() > 2 &&
         base::SecondsBetween(entries_[1].stamp, reading.stamp) >
             kRemembered_s) {
    entries_.pop_front();
  }
}

void DeadReckoning::SetPose(const geometry::Rigid2& map_from_base) {
  map_from_odom_ =
      entries_.empty()
          ? map_from_base
          : map_from_base * entries_.back().odom_from_base.Inverse();
}

std::optional<ReckonedPose> DeadReckoning::Newest() const {
  if (!last_.has_value()) return std::nullopt;
  return ReckonedPose{
      .stamp = last_->stamp,
      .map_from_base = map_from_odom_ * entries_.back().odom_from_base,
      .forward_mps = last_->forward_mps,
      .yaw_rate_radps = last_->yaw_rate_radps};
}

std::optional<geometry::Rigid2> DeadReckoning::At(
    base::MonotonicTime stamp) const {
  if (entries_.empty() || stamp < entries_.front().stamp) return std::nullopt;
  const double ahead_s = base::SecondsBetween(entries_.back().stamp, stamp);
  if (ahead_s >= 0) {
    if (ahead_s > kMaxAhead_s) return std::nullopt;
    return map_from_odom_ * MovedOn(entries_.back().odom_from_base,
                                    last_->forward_mps, last_->yaw_rate_radps,
                                    ahead_s);
  }
  size_t after = entries_.size() - 1;
  while (entries_[after - 1].stamp > stamp) --after;
  const Entry& a = entries_[after - 1];
  const Entry& b = entries_[after];
  const double share = base::SecondsBetween(a.stamp, stamp) /
                       base::SecondsBetween(a.stamp, b.stamp);
  const geometry::Vec2 way =
      b.odom_from_base.translation - a.odom_from_base.translation;
  const double turn_rad = geometry::NormalizedAngle_rad(
      b.odom_from_base.yaw_rad - a.odom_from_base.yaw_rad);
  return map_from_odom_ *
         geometry::Rigid2{a.odom_from_base.translation + share * way,
                          a.odom_from_base.yaw_rad + share * turn_rad};
}

}  // namespace treeline::mapless
