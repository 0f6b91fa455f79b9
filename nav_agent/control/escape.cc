#include "nav_agent/control/escape.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

namespace treeline::control {
namespace {

constexpr double kHold_s = 0.7;
constexpr double kAhead_s[] = {1.0, 2.0};
// The point of the track that the robot should look at (m).
constexpr double kLook_m = 0.8;
// What a place costs from where it may not move as it wants to either (rad).
constexpr double kHeldToo = 0.5;
// What room beside the robot is worth, up to how much (rad of heading for 1 m).
constexpr double kRoomWorth = 6;
constexpr double kRoomMost_m = 0.15;
constexpr double kSpeeds_mps[] = {0.12, 0.06, 0.0, -0.06, -0.12};
constexpr double kYawRates_radps[] = {0.0, 0.35, -0.35, 0.7, -0.7};
constexpr double kTurn_radps = 0.35;

std::vector<GuardPoint> SeenFrom(const geometry::Rigid2& base_from_there,
                                 std::span<const GuardPoint> points) {
  const geometry::Rigid2 there_from_base = base_from_there.Inverse();
  std::vector<GuardPoint> seen(points.begin(), points.end());
  for (GuardPoint& point : seen)
    point.in_base = there_from_base * point.in_base;
  return seen;
}

}  // namespace

std::optional<core::VelocityCommand> Escape::Find(
    const ControlPose& pose, std::span<const TrackPoint> track,
    const core::VelocityCommand& wanted, bool may_back_up,
    const LocalCostmap& costmap, const CollisionGuard& guard,
    std::span<const GuardPoint> points) {
  if (!guard.Check(wanted, points).is_limited && !held_.has_value()) {
    return std::nullopt;
  }
  const bool holds =
      held_.has_value() &&
      std::chrono::duration<double>(pose.stamp - held_since_).count() < kHold_s;
  if (holds && (may_back_up || held_->forward_mps >= 0) &&
      !guard.Check(*held_, points).is_limited)
    return held_;
  geometry::Vec2 target = track.back().in_map;
  double along_m = 0;
  for (size_t i = 1; i < track.size(); ++i) {
    along_m += geometry::Norm(track[i].in_map - track[i - 1].in_map);
    if (along_m < kLook_m) continue;
    target = track[i].in_map;
    break;
  }
  // After a motion: what it has brought, and whether the robot may go on from
  // there.
  const auto price = [&](const geometry::Rigid2& motion) {
    const geometry::Rigid2 at = pose.pose.map_from_base * motion;
    const geometry::Vec2 to = at.Inverse() * target;
    const double angle_rad = std::atan2(to.y, to.x);
    const double room_m = costmap.FootprintDistance_m(at, kRoomMost_m);
    const core::VelocityCommand turn = {
        .forward_mps = 0,
        .yaw_rate_radps = std::copysign(kTurn_radps, angle_rad)};
    const bool is_held = guard.Check(turn, SeenFrom(motion, points)).is_limited;
    return std::abs(angle_rad) + geometry::Norm(to) - kRoomWorth * room_m +
           (is_held ? kHeldToo : 0);
  };
  held_.reset();
  double best = price({}) - 0.02;
  for (const double speed : kSpeeds_mps) {
    if (speed < 0 && !may_back_up) continue;
    for (const double yaw_rate : kYawRates_radps) {
      const core::VelocityCommand command = {.forward_mps = speed,
                                             .yaw_rate_radps = yaw_rate};
      if (speed == 0 && yaw_rate == 0) continue;
      if (guard.Check(command, points).is_limited) continue;
      for (const double ahead_s : kAhead_s) {
        const double then = price(MotionIn(ahead_s, command));
        if (then >= best) continue;
        best = then;
        held_ = command;
      }
    }
  }
  held_since_ = pose.stamp;
  return held_;
}

}  // namespace treeline::control
