#include "nav_agent/control/rounded_turn.h"

#include <algorithm>
#include <cmath>

namespace treeline::control {
namespace {

// Slower turns sweep nothing (rad/s).
constexpr double kLeast_radps = 0.1;
// So far ahead there must be so much room beside the footprint (s, m).
constexpr double kAhead_s[] = {0.3, 0.6, 0.9, 1.2};
constexpr double kRoom_m = 0.06;
// The rear corner may move outwards so fast meanwhile (m/s): speed and turn
// rate grow together.
constexpr double kOutward_mps = 0.01;

}  // namespace

core::VelocityCommand RoundedTurn(const ControlPose& pose,
                                  const core::VelocityCommand& wanted,
                                  const core::RobotModel& robot,
                                  const LocalCostmap& costmap,
                                  const CollisionGuard& guard,
                                  std::span<const GuardPoint> points) {
  const double turn_radps = std::abs(wanted.yaw_rate_radps);
  const double needed_mps = robot.half_width_m * turn_radps;
  if (turn_radps < kLeast_radps || wanted.forward_mps < 0 ||
      wanted.forward_mps >= needed_mps) {
    return wanted;
  }
  core::VelocityCommand arc = {
      .forward_mps = std::min(needed_mps, robot.max_forward_mps),
      .yaw_rate_radps = wanted.yaw_rate_radps};
  for (const double ahead_s : kAhead_s) {
    const geometry::Rigid2 there =
        pose.pose.map_from_base * MotionIn(ahead_s, arc);
    if (costmap.FootprintDistance_m(there, 2 * kRoom_m) < kRoom_m) {
      return wanted;
    }
  }
  if (guard.Check(arc, points).is_limited) return wanted;
  const double swept_radps =
      (std::max(0.0, pose.forward_mps) + kOutward_mps) / robot.half_width_m;
  arc.yaw_rate_radps =
      std::copysign(std::min(turn_radps, swept_radps), wanted.yaw_rate_radps);
  return arc;
}

}  // namespace treeline::control
