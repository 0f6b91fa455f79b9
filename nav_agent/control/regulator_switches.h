// Which velocity regulators are at work.
#ifndef NAV_AGENT_CONTROL_REGULATOR_SWITCHES_H_
#define NAV_AGENT_CONTROL_REGULATOR_SWITCHES_H_

namespace treeline::control {

// Of the speed at each point of a track, in the order of SpeedProfile.
struct SpeedRegulatorSwitches {
  bool clearance = true;
  bool curvature = true;
  bool corner = true;
  bool slope = true;
  bool zone = true;
  bool braking = true;
};

// Of the command, in the order of VelocityRegulators. All are on but in tests
// and experiments: no setting of the agent switches one off. Without `sensors`
// and `collision` the robot runs into what it sees.
struct VelocityRegulatorSwitches {
  bool approach = true;
  bool pursuit = true;
  bool escape = true;
  bool rounded_turn = true;
  bool wait = true;
  bool speed_zone = true;
  bool sensors = true;
  bool acceleration = true;
  bool collision = true;
  // Within `pursuit`.
  SpeedRegulatorSwitches speed;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_REGULATOR_SWITCHES_H_
