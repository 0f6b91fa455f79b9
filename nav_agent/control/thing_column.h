// A cell of the map that something stands in, and what a sensor says of it.
#ifndef NAV_AGENT_CONTROL_THING_COLUMN_H_
#define NAV_AGENT_CONTROL_THING_COLUMN_H_

#include <cstdint>

#include "common/geometry/rigid2.h"

namespace treeline::control {

// From the ground up to the robot's height.
struct ThingColumn {
  geometry::Vec2 center_in_map;
  // Of its surface (m).
  double ground_m = 0;
  // Of the cell's side (m).
  double half_width_m = 0;
};

enum class ColumnSight : uint8_t {
  kUnknown,  // not in view, hidden, or not measured
  kMet,      // something is there
  kThrough   // what lies beyond was seen, over the column's whole width
};

// What a laser says of it.
struct LaserSight {
  ColumnSight sight = ColumnSight::kUnknown;
  // How far its beams reach there, the shortest (m).
  double range_m = 0;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_THING_COLUMN_H_
