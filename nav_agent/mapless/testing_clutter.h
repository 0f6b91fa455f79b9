// Things that stand about, for tests.
#ifndef NAV_AGENT_MAPLESS_TESTING_CLUTTER_H_
#define NAV_AGENT_MAPLESS_TESTING_CLUTTER_H_

#include "nav_agent/core/robot_model.h"
#include "nav_agent/mapless/evidence_grid.h"

namespace treeline::mapless {

// Everything along a line stands in the way.
inline void AddWall(geometry::Vec2 from, geometry::Vec2 to, EvidenceGrid& map) {
  const double length_m = geometry::Norm(to - from);
  for (double at_m = 0; at_m <= length_m; at_m += map.cell_m() / 2) {
    map.Mark(from + (at_m / length_m) * (to - from));
  }
}

// 0.5 x 0.4 m, about its middle.
inline core::RobotModel SmallRobot() {
  core::RobotModel robot;
  robot.front_m = 0.25;
  robot.rear_m = 0.25;
  robot.half_width_m = 0.2;
  robot.wheel_track_m = 0.36;
  robot.caster_m = 0.2;
  robot.max_forward_mps = 1.5;
  robot.max_acceleration_mps2 = 2;
  robot.max_deceleration_mps2 = 3;
  robot.max_yaw_rate_radps = 2;
  robot.max_yaw_acceleration_radps2 = 8;
  return robot;
}

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_TESTING_CLUTTER_H_
