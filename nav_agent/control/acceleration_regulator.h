// What the base can do next.
#ifndef NAV_AGENT_CONTROL_ACCELERATION_REGULATOR_H_
#define NAV_AGENT_CONTROL_ACCELERATION_REGULATOR_H_

#include "nav_agent/control/velocity_limits.h"
#include "nav_agent/control/velocity_regulator.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

// Speeds and accelerations within the robot's, from the last command on
// (LimitedVelocity). One that must stop brakes along its arc (LimitedTogether).
// A turn is begun faster than a drive, so an arc begins as a tighter one: what
// would keep to the arc is said, too.
class AccelerationRegulator final : public VelocityRegulator {
 public:
  explicit AccelerationRegulator(const core::RobotModel& robot)
      : robot_(robot) {}

  const char* name() const override { return "acceleration"; }
  void Regulate(const RegulatorInput& input,
                RegulatedVelocity& regulated) override {
    const core::VelocityCommand together =
        LimitedTogether(input.start.velocity, regulated.velocity,
                        input.start.interval_s, robot_);
    if (regulated.must_stop) {
      regulated.velocity = together;
      return;
    }
    regulated.along_arc = together;
    regulated.velocity =
        LimitedVelocity(input.start.velocity, regulated.velocity,
                        input.start.interval_s, robot_);
  }

 private:
  core::RobotModel robot_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_ACCELERATION_REGULATOR_H_
