// The cheapest way of a disc: what a footprint's way may follow.
#ifndef NAV_AGENT_PLANNING_GUIDE_H_
#define NAV_AGENT_PLANNING_GUIDE_H_

#include <functional>

#include "nav_agent/planning/configuration_space.h"
#include "nav_agent/planning/variable_rrt.h"

namespace treeline::planning {

// The cheapest way over cells (A*, steps to 16 neighbours: lengths are at most
// 2.7 % above the shortest) for a disc as wide as the footprint's narrowest
// part. Turns and the footprint's corners are not looked at, so it need not be
// one that can be driven; but where there is none there is no way at all. From
// `start` to `goal`, with cells' centres between; empty: none, or `is_over`
// said so.
Polyline FindGridPath(const ConfigurationSpace& space, const Spot& start,
                      const Spot& goal, const std::function<bool()>& is_over);

// The cheapest way over some of `points`, in their order, from the first to the
// last, whose lines and turns can be driven: by dynamic programming over points
// spacing_m apart (m), each with the heading of the best way to it. Empty if
// there is none.
Polyline ShortcutPolyline(const ConfigurationSpace& space, double start_yaw_rad,
                          double goal_yaw_rad, const Polyline& points,
                          double spacing_m);

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_GUIDE_H_
