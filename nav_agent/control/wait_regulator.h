// Who waits stands.
#ifndef NAV_AGENT_CONTROL_WAIT_REGULATOR_H_
#define NAV_AGENT_CONTROL_WAIT_REGULATOR_H_

#include "nav_agent/control/velocity_regulator.h"

namespace treeline::control {

// No velocity while the robot should wait; what it would do stays in `wanted`.
// A robot at its goal does not wait.
class WaitRegulator final : public VelocityRegulator {
 public:
  const char* name() const override { return "wait"; }
  void Regulate(const RegulatorInput& input,
                RegulatedVelocity& regulated) override {
    if (!input.should_wait || regulated.is_at_goal) return;
    regulated.waits = true;
    regulated.velocity = {};
  }
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_WAIT_REGULATOR_H_
