// Turning on the spot.
#ifndef NAV_AGENT_CONTROL_TURN_RATE_H_
#define NAV_AGENT_CONTROL_TURN_RATE_H_

#include "nav_agent/core/robot_model.h"

namespace treeline::control {

// Turning on the spot by an angle, to stand after it: the yaw rate from which
// the robot can brake in time, at most kYawShare of its own limit.
double TurnOnSpotRate_radps(double angle_rad, const core::RobotModel& robot);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_TURN_RATE_H_
