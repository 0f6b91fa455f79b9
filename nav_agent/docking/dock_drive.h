// How a robot drives into its dock, and out: velocities from where it is.
#ifndef NAV_AGENT_DOCKING_DOCK_DRIVE_H_
#define NAV_AGENT_DOCKING_DOCK_DRIVE_H_

#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/docking/dock.h"

namespace treeline::docking {

// Along the dock's line, which a robot beside it, or turned, is pulled onto:
// with its travel u, aside' = u sin(turned) and turned' = u k,
//
//   k = -aside / l^2 - 2 turned / l,  l = staging distance / kLinesInWay
//
// is critically damped. Slower the nearer the docked pose is: kSpeedOfWay_ps of
// the way, from kDockSpeed_mps to kTouchSpeed_mps.
core::VelocityCommand DriveIn(const Dock& dock, const DockOffset& off,
                              const core::RobotModel& robot);
// Straight on at kTouchSpeed_mps, for the contact.
core::VelocityCommand PressOn(const Dock& dock);
// The way back, on the same line.
core::VelocityCommand DriveOut(const Dock& dock, const DockOffset& off,
                               const core::RobotModel& robot);
// On the spot, until it is straight.
core::VelocityCommand TurnStraight(const DockOffset& off);

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_DOCK_DRIVE_H_
