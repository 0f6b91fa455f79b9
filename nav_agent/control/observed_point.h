// A point of something that a sensor saw.
#ifndef NAV_AGENT_CONTROL_OBSERVED_POINT_H_
#define NAV_AGENT_CONTROL_OBSERVED_POINT_H_

#include "common/geometry/rigid2.h"

namespace treeline::control {

struct ObservedPoint {
  geometry::Vec2 in_map;
  // It was not there a moment ago.
  bool is_moving = false;
  // The map has nothing there.
  bool is_new = false;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_OBSERVED_POINT_H_
