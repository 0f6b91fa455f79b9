// Whether a scan contradicts what the map has about a place.
#ifndef NAV_AGENT_BEHAVIOR_SEEN_THROUGH_H_
#define NAV_AGENT_BEHAVIOR_SEEN_THROUGH_H_

#include <span>

#include "common/geometry/rigid2.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::behavior {

// A scan of a robot that may stand there.
struct ScanFromPlace {
  geometry::Rigid2 map_from_base;
  geometry::Vec2 laser_in_base;
  // As RobotTracker::ScanInBase.
  std::span<const geometry::Vec2> ends_in_base;
};

// True if all that the map has nearer than within_m to the base, and what hangs
// together with it, is not there any more: it ends within kGhostReach_m of the
// base, beams pass through cells of it beside the robot that side by side are
// kMinSeenThrough_m wide, and hardly one ends on it. What reaches further is a
// wall. What lies wholly under the robot no beam passes, so it stays. Low
// things, over which the laser sees, are taken for gone, too: the scan must fit
// besides.
bool IsSeenThrough(const traversability::NavigationMap& map, int level,
                   const ScanFromPlace& scan, double within_m,
                   const core::RobotModel& robot);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_SEEN_THROUGH_H_
