#include "nav_agent/control/rounded_turn_regulator.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/manoeuvre_parameters.h"

namespace treeline::control {

void RoundedTurnRegulator::Regulate(const RegulatorInput& input,
                                    RegulatedVelocity& regulated) {
  if (!input.people_are_about || regulated.is_turning_at_goal ||
      regulated.is_at_goal || regulated.escapes) {
    return;
  }
  const core::VelocityCommand& wanted = regulated.velocity;
  const double turn_radps = std::abs(wanted.yaw_rate_radps);
  const double needed_mps = robot_.half_width_m * turn_radps;
  if (turn_radps < kStandingTurn_radps || wanted.forward_mps < 0 ||
      wanted.forward_mps >= needed_mps) {
    return;
  }
  core::VelocityCommand arc = {
      .forward_mps = std::min(needed_mps, robot_.max_forward_mps),
      .yaw_rate_radps = wanted.yaw_rate_radps};
  for (const double ahead_s : kRoundedAhead_s.value) {
    const geometry::Rigid2 there =
        input.pose.pose.map_from_base * MotionIn(ahead_s, arc);
    if (input.costmap.FootprintDistance_m(there, 2 * kManoeuvreRoom_m) <
        kManoeuvreRoom_m) {
      return;
    }
  }
  if (input.guard.Check(arc, input.points).is_limited) return;
  // Speed and turn rate grow together.
  const double swept_radps =
      (std::max(0.0, input.pose.forward_mps) + kOutwardSpeed_mps) /
      robot_.half_width_m;
  arc.yaw_rate_radps =
      std::copysign(std::min(turn_radps, swept_radps), wanted.yaw_rate_radps);
  regulated.velocity = arc;
}

}  // namespace treeline::control
