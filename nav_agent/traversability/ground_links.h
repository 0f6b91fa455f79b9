// The steps by which FindGround joins the ground's voxels, after those of
// ground_stages.h: which are continuous, how steep they are, and where they
// end.
#ifndef NAV_AGENT_TRAVERSABILITY_GROUND_LINKS_H_
#define NAV_AGENT_TRAVERSABILITY_GROUND_LINKS_H_

#include "nav_agent/traversability/ground.h"
#include "nav_agent/traversability/ground_stages.h"

namespace treeline::traversability {

// Links continuous ground, and finds where it ends.
void LinkGround(const CleanColumns& columns, const VoxelLimits& limits,
                GroundColumns& ground);
void MeasureGradients(GroundColumns& ground);
void FindNarrowGround(const VoxelLimits& limits, GroundColumns& ground);

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_GROUND_LINKS_H_
