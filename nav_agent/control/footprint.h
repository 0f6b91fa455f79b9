// What a robot covers of the ground: a rectangle about its base.
#ifndef NAV_AGENT_CONTROL_FOOTPRINT_H_
#define NAV_AGENT_CONTROL_FOOTPRINT_H_

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

struct Footprint {
  double front_m = 0;
  double rear_m = 0;
  double half_width_m = 0;

  static Footprint Of(const core::RobotModel& robot) {
    return {.front_m = robot.front_m,
            .rear_m = robot.rear_m,
            .half_width_m = robot.half_width_m};
  }

  // From the rectangle's edge to a point; negative inside (m).
  double DistanceTo_m(geometry::Vec2 point_in_base) const {
    const double x =
        std::max(point_in_base.x - front_m, -rear_m - point_in_base.x);
    const double y = std::abs(point_in_base.y) - half_width_m;
    if (x <= 0 || y <= 0) return std::max(x, y);
    return std::sqrt(x * x + y * y);
  }
  // The fastest that a part of its edge within reach_m of a point moves
  // outwards, at right angles to that edge (m/s): what stands or walks there is
  // touched by the robot's motion if that is more than 0.
  double OutwardSpeed_mps(const core::VelocityCommand& motion,
                          geometry::Vec2 point_in_base, double reach_m) const;
  double Circumradius_m() const {
    return std::hypot(std::max(front_m, rear_m), half_width_m);
  }
  // Of the largest circle about the base that it holds.
  double Inradius_m() const {
    return std::min({front_m, rear_m, half_width_m});
  }
  // Points on its edge, corners included, at most spacing_m apart.
  std::vector<geometry::Vec2> Edge(double spacing_m) const;
  // Points all over it, edge included, at most spacing_m apart along each axis.
  std::vector<geometry::Vec2> Area(double spacing_m) const;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_FOOTPRINT_H_
