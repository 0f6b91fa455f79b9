// Turns that leave what is behind the robot alone.
#ifndef NAV_AGENT_CONTROL_ROUNDED_TURN_H_
#define NAV_AGENT_CONTROL_ROUNDED_TURN_H_

#include <span>

#include "nav_agent/control/collision_guard.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

// A robot that turns on the spot sweeps its rear edge backwards, where no
// sensor looks. One that drives ahead meanwhile, as fast as its rear corner
// would go back, does not. `wanted` that turns more than that, as such an arc,
// where the costmap and the guard leave room for the next 1.2 s of it;
// otherwise `wanted`.
core::VelocityCommand RoundedTurn(const ControlPose& pose,
                                  const core::VelocityCommand& wanted,
                                  const core::RobotModel& robot,
                                  const LocalCostmap& costmap,
                                  const CollisionGuard& guard,
                                  std::span<const GuardPoint> points);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_ROUNDED_TURN_H_
