// The low ends of ramps' sides, which a voxel map shows as ground.
#ifndef NAV_AGENT_TRAVERSABILITY_RAMP_EDGES_H_
#define NAV_AGENT_TRAVERSABILITY_RAMP_EDGES_H_

#include <cstdint>
#include <vector>

#include "nav_agent/traversability/traversability.h"

namespace treeline::traversability {

// 1 for free cells of sloped ground that end in a step of one voxel downwards
// across the slope: beside a ramp's first half metre the floor is less than two
// voxels below it, so the map takes that side for ground like the ramp's own
// steps, but a wheel cannot climb it. The slope's direction is that of a plane
// through the sloped ground in sight within 1.3 m that is not lower, the step's
// that of the mean of all steps within two cells. The same at a ramp's upper
// end, where the floor it leads to is a voxel higher than the ramp beside it.
// One value a cell, in the grid's order.
std::vector<uint8_t> RampSideEdges(const TraversableLevel& level);

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_RAMP_EDGES_H_
