#include "nav_agent/control/collision_regulator.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/manoeuvre_parameters.h"

namespace treeline::control {
namespace {

void Say(const GuardVerdict& verdict, const RegulatorInput& input,
         RegulatedVelocity& regulated) {
  regulated.is_limited = true;
  regulated.point_in_map =
      input.pose.pose.map_from_base * verdict.point_in_base;
  regulated.point_moves = verdict.point_moves;
}

// The first step of a velocity.
core::VelocityCommand BeginningOf(const core::VelocityCommand& wanted) {
  const double share = std::min(
      {1.0, kSlowSpeed_mps / std::max(std::abs(wanted.forward_mps), 1e-6),
       kSlowTurn_radps / std::max(std::abs(wanted.yaw_rate_radps), 1e-6)});
  return {.forward_mps = share * wanted.forward_mps,
          .yaw_rate_radps = share * wanted.yaw_rate_radps};
}

}  // namespace

void CollisionRegulator::Regulate(const RegulatorInput& input,
                                  RegulatedVelocity& regulated) {
  if (!regulated.must_stop) {
    const GuardVerdict verdict =
        input.guard.Check(regulated.velocity, input.points);
    // Where there is no room for a tighter arc there may be for the wanted one.
    if (verdict.is_limited && regulated.along_arc.has_value() &&
        !input.guard.Check(*regulated.along_arc, input.points).is_limited) {
      regulated.velocity = *regulated.along_arc;
    } else if (verdict.is_limited) {
      regulated.velocity =
          LimitedTogether(input.start.velocity, verdict.command,
                          input.start.interval_s, robot_);
      Say(verdict, input, regulated);
    }
  }
  if (regulated.waits) {
    const GuardVerdict verdict =
        input.guard.Check(BeginningOf(regulated.wanted), input.points);
    if (verdict.is_limited) Say(verdict, input, regulated);
  }
}

}  // namespace treeline::control
