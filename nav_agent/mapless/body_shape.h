// What rollouts and ways must know of a robot's body.
#ifndef NAV_AGENT_MAPLESS_BODY_SHAPE_H_
#define NAV_AGENT_MAPLESS_BODY_SHAPE_H_

#include <vector>

#include "nav_agent/core/robot_model.h"
#include "nav_agent/mapless/clearance_window.h"

namespace treeline::mapless {

class BodyShape {
 public:
  // margin_m: kept free around the body.
  BodyShape(const core::RobotModel& robot, double margin_m);

  // From the base's origin: to the nearest side, and to the farthest corner,
  // margins included (m).
  double inner_m() const { return inner_m_; }
  double outer_m() const { return outer_m_; }

  // Room between the body, with its margin, and the nearest thing, at least; a
  // negative number: they touch. Beyond wanted_m it is not told how much.
  double RoomAt_m(const ClearanceWindow& clearance,
                  const geometry::Rigid2& map_from_base, double wanted_m) const;
  // From the body, without its margin, to a point (m); 0: it is within.
  double DistanceTo_m(const geometry::Rigid2& map_from_base,
                      geometry::Vec2 point_in_map) const;

 private:
  double margin_m_;
  // The body's corners, in the base's frame.
  geometry::Vec2 low_;
  geometry::Vec2 high_;
  double inner_m_;
  double outer_m_;
  // Points of the rim, in the base's frame.
  std::vector<geometry::Vec2> rim_;
};

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_BODY_SHAPE_H_
