// A thing that a robot may come closer to than to anything else: its dock.
#ifndef NAV_AGENT_CONTROL_CLOSE_APPROACH_H_
#define NAV_AGENT_CONTROL_CLOSE_APPROACH_H_

#include <cmath>

#include "common/geometry/rigid2.h"
#include "nav_agent/control/footprint.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/control/setting_parameters.h"

namespace treeline::control {

struct CloseApproach {
  // Where the robot stands at last, and whether its rear is at the thing then.
  geometry::Rigid2 map_from_docked;
  bool is_backward = false;

  // The thing is what lies beyond the robot's edge as it stands at last, a cell
  // of a costmap before it (so far off are cells and estimates), and no wider
  // than the robot with what else it keeps clear of beside it. Whatever stands
  // before that, or beside it, is something else.
  bool IsOfThing(geometry::Vec2 point_in_map, const Footprint& robot) const {
    const geometry::Vec2 in_docked = map_from_docked.Inverse() * point_in_map;
    const double ahead_m = is_backward ? -in_docked.x : in_docked.x;
    const double edge_m = is_backward ? robot.rear_m : robot.front_m;
    return ahead_m >= edge_m - kCostmapResolution_m &&
           std::abs(in_docked.y) <= robot.half_width_m + kBodyWidening_m;
  }
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_CLOSE_APPROACH_H_
