// A search that leaves nothing out, for ways too narrow for trees.
#ifndef NAV_AGENT_PLANNING_LATTICE_H_
#define NAV_AGENT_PLANNING_LATTICE_H_

#include <functional>

#include "nav_agent/planning/configuration_space.h"
#include "nav_agent/planning/variable_rrt.h"

namespace treeline::planning {

// A way that can be driven, over points one cell apart and 16 headings, with
// the footprint itself: weighted A*, guided by the way of the inscribed disc
// from everywhere to the goal. Empty if there is none in that grid, or if
// `is_over`.
Polyline SearchLattice(const ConfigurationSpace& space, const Stand& start,
                       const Stand& goal, const std::function<bool()>& is_over);

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_LATTICE_H_
