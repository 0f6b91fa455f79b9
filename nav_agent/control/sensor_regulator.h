// Who does not see stops.
#ifndef NAV_AGENT_CONTROL_SENSOR_REGULATOR_H_
#define NAV_AGENT_CONTROL_SENSOR_REGULATOR_H_

#include <cmath>

#include "nav_agent/control/velocity_regulator.h"

namespace treeline::control {

// The robot must stop if a laser is silent, its pose is not finite, or the
// velocity that is wanted is not.
class SensorRegulator final : public VelocityRegulator {
 public:
  const char* name() const override { return "sensors"; }
  void Regulate(const RegulatorInput& input,
                RegulatedVelocity& regulated) override {
    if (input.sees && std::isfinite(regulated.velocity.forward_mps) &&
        std::isfinite(regulated.velocity.yaw_rate_radps)) {
      return;
    }
    regulated.must_stop = true;
    regulated.is_limited = true;
    regulated.velocity = {};
  }
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_SENSOR_REGULATOR_H_
