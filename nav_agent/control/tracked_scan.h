// A scan with the place that it was taken from, and what a laser says of a
// place.
#ifndef NAV_AGENT_CONTROL_TRACKED_SCAN_H_
#define NAV_AGENT_CONTROL_TRACKED_SCAN_H_

#include <optional>
#include <span>

#include "common/geometry/rigid3.h"
#include "nav_agent/control/observed_point.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

// A scan, from where it was taken, and what of it stands near the robot: what
// moves is marked.
struct TrackedScan {
  core::RangeSensorInfo laser;
  geometry::Rigid3 map_from_laser;
  core::LaserScan scan;
  std::span<const ObservedPoint> points;
};

// The beam that goes nearest to a place.
struct BeamTowards {
  // What it measured; the place's distance (m).
  double range_m = 0;
  double away_m = 0;
  // Aside from there to where the laser's view ends (m).
  double to_edge_m = 0;
};

// nullopt: the laser does not look there, or the beam measured nothing.
std::optional<BeamTowards> BeamTo(const TrackedScan& look,
                                  geometry::Vec2 in_map);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_TRACKED_SCAN_H_
