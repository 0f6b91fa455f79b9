// All regulators of the robot's velocity, one after the other.
#ifndef NAV_AGENT_CONTROL_VELOCITY_REGULATORS_H_
#define NAV_AGENT_CONTROL_VELOCITY_REGULATORS_H_

#include <memory>
#include <string>
#include <vector>

#include "nav_agent/control/approach_regulator.h"
#include "nav_agent/control/regulator_switches.h"
#include "nav_agent/control/setting_parameters.h"
#include "nav_agent/control/velocity_regulator.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

struct VelocityRegulatorsOptions {
  ApproachOptions approach;
  // The robot's own limit holds beside this.
  double max_forward_mps = kMaxForward_mps;
  VelocityRegulatorSwitches switches;
};

// From standing still to a command, in this order:
//
//   steering, along a path:
//     1. ApproachRegulator      the last decimetres, onto the goal
//     2. PursuitRegulator       else along the track, as fast as the
//                               regulators of SpeedProfile allow
//     3. EscapeRegulator        small other moves when it does not get on
//     4. RoundedTurnRegulator   turns that sweep nothing back, among people
//   stopping, of any command:
//     5. WaitRegulator          who waits stands
//     6. SpeedZoneRegulator     as slow as the zone it is in
//     7. SensorRegulator        who does not see stops
//     8. AccelerationRegulator  what the base can do next
//     9. CollisionRegulator     not into what is seen or known
//
// 1. and 2. give a velocity, the others change it. The last two stay last:
// nothing comes between them and the base. Not thread-safe.
class VelocityRegulators {
 public:
  VelocityRegulators(const core::RobotModel& robot,
                     const VelocityRegulatorsOptions& options);

  // All of them.
  RegulatedVelocity Drive(const RegulatorInput& input);
  // Those that stop, of a command of somebody else.
  RegulatedVelocity Allow(const RegulatorInput& input,
                          const core::VelocityCommand& wanted);
  // There is a new path.
  void Reset();

  // Of those at work, in their order.
  std::vector<std::string> Names() const;

 private:
  using Chain = std::vector<std::unique_ptr<VelocityRegulator>>;

  Chain steering_;
  Chain stopping_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_VELOCITY_REGULATORS_H_
