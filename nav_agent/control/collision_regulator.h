// Not into what is seen or known.
#ifndef NAV_AGENT_CONTROL_COLLISION_REGULATOR_H_
#define NAV_AGENT_CONTROL_COLLISION_REGULATOR_H_

#include "nav_agent/control/velocity_regulator.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

// What the CollisionGuard allows; what it does not becomes the nearest that it
// does, braking along the arc. Says what forbids it. Of a robot that waits it
// looks whether what is wanted could begin: at kSlowSpeed_mps and
// kSlowTurn_radps at most.
class CollisionRegulator final : public VelocityRegulator {
 public:
  explicit CollisionRegulator(const core::RobotModel& robot) : robot_(robot) {}

  const char* name() const override { return "collision"; }
  void Regulate(const RegulatorInput& input,
                RegulatedVelocity& regulated) override;

 private:
  core::RobotModel robot_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_COLLISION_REGULATOR_H_
