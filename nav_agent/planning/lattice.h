// A search that leaves nothing out, for ways too narrow for trees.
#ifndef NAV_AGENT_PLANNING_LATTICE_H_
#define NAV_AGENT_PLANNING_LATTICE_H_

#include <functional>

#include "nav_agent/planning/configuration_space.h"
#include "nav_agent/planning/planner_parameters.h"
#include "nav_agent/planning/regions.h"
#include "nav_agent/planning/variable_rrt.h"

namespace treeline::planning {

// A way that can be driven, over points one cell apart and 16 headings, with
// the footprint itself: weighted A*, guided by the way of the inscribed disc
// from everywhere to the goal over `regions` of that space. Empty if there is
// none in that grid, or if `is_over`. The start's and the goal's cells must be
// of one area. What is left to go counts `weight` times: the way costs at most
// so much more than the cheapest one in that grid.
Polyline SearchLattice(const ConfigurationSpace& space, const Regions& regions,
                       const Stand& start, const Stand& goal,
                       const std::function<bool()>& is_over,
                       double weight = kGreed);
// The same for a goal near by: no further from it than reach_m, and after at
// most so many nodes.
Polyline SearchLatticeNear(const ConfigurationSpace& space,
                           const Regions& regions, const Stand& start,
                           const Stand& goal, double reach_m, int max_nodes,
                           const std::function<bool()>& is_over);

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_LATTICE_H_
