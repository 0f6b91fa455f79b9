// A line to drive along.
#ifndef NAV_AGENT_CONTROL_TRACK_POINT_H_
#define NAV_AGENT_CONTROL_TRACK_POINT_H_

#include <limits>

#include "common/geometry/rigid2.h"

namespace treeline::control {

// A point of the line that is driven along.
struct TrackPoint {
  geometry::Vec2 in_map;
  // The free distance of the footprint there (m), and the ground's slope.
  double clearance_m = 1;
  double slope_rad = 0;
  // What speed zones allow there (m/s).
  double max_mps = std::numeric_limits<double>::infinity();
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_TRACK_POINT_H_
