// What the collision guard keeps a robot away from.
#ifndef NAV_AGENT_CONTROL_GUARD_POINTS_H_
#define NAV_AGENT_CONTROL_GUARD_POINTS_H_

#include <span>
#include <vector>

#include "nav_agent/control/close_approach.h"
#include "nav_agent/control/collision_guard.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/dynamic_obstacle_tracker.h"
#include "nav_agent/control/local_costmap.h"

namespace treeline::control {

// In the robot's base at `pose`, within the guard's reach: the newest scans'
// and, if it is not older than kDepthLifetime_s, the newest frame's points;
// what the costmap has where no sensor looks; the map's about the place that a
// robot which is lost supposes; and movers that are out of sight. Each with the
// margin that the guard's options have for its kind.
//
// approach: null, or the thing that the robot drives up to. What is seen of it
// has no margin; what is only remembered of it, or is the map's, is left out:
// cells are too coarse to come up to.
std::vector<GuardPoint> GuardPointsOf(const ControlPose& pose,
                                      const LocalCostmap& costmap,
                                      std::span<const DynamicObstacle> movers,
                                      const CollisionGuard& guard,
                                      const CloseApproach* approach = nullptr);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_GUARD_POINTS_H_
