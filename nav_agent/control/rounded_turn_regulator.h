// Turns that leave what is behind the robot alone.
#ifndef NAV_AGENT_CONTROL_ROUNDED_TURN_REGULATOR_H_
#define NAV_AGENT_CONTROL_ROUNDED_TURN_REGULATOR_H_

#include "nav_agent/control/velocity_regulator.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

// A robot that turns on the spot sweeps its rear edge backwards, where no
// sensor looks. One that drives ahead meanwhile, as fast as its rear corner
// would go back, does not. While people are about, a velocity that turns more
// than that becomes such an arc, where the costmap and the guard leave room for
// the next 1.2 s of it; not at the goal, where it has to turn, and not while
// it escapes.
class RoundedTurnRegulator final : public VelocityRegulator {
 public:
  explicit RoundedTurnRegulator(const core::RobotModel& robot)
      : robot_(robot) {}

  const char* name() const override { return "rounded_turn"; }
  void Regulate(const RegulatorInput& input,
                RegulatedVelocity& regulated) override;

 private:
  core::RobotModel robot_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_ROUNDED_TURN_REGULATOR_H_
