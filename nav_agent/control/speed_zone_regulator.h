// Any command in a speed zone is as slow as that.
#ifndef NAV_AGENT_CONTROL_SPEED_ZONE_REGULATOR_H_
#define NAV_AGENT_CONTROL_SPEED_ZONE_REGULATOR_H_

#include <cmath>

#include "nav_agent/control/velocity_regulator.h"

namespace treeline::control {

// Along the same arc, no faster than the speed zones at the robot's place
// allow: ahead and back, whoever asks for it. Along a path, ZoneRegulator has
// it slow down before.
class SpeedZoneRegulator final : public VelocityRegulator {
 public:
  const char* name() const override { return "speed_zone"; }
  void Regulate(const RegulatorInput& input,
                RegulatedVelocity& regulated) override {
    core::VelocityCommand& velocity = regulated.velocity;
    const double speed_mps = std::abs(velocity.forward_mps);
    if (!(speed_mps > input.max_mps)) return;
    const double share = input.max_mps / speed_mps;
    velocity.forward_mps *= share;
    velocity.yaw_rate_radps *= share;
  }
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_SPEED_ZONE_REGULATOR_H_
