// Floors whose voxels scatter: what lies between their heights.
#ifndef NAV_AGENT_TRAVERSABILITY_ROUGH_GROUND_H_
#define NAV_AGENT_TRAVERSABILITY_ROUGH_GROUND_H_

#include "nav_agent/traversability/ground.h"

namespace treeline::traversability {

// Puts a surface in the place of tops that scatter about it: where depth was
// noisy, or poses were when depth was fused, a floor's tops differ by several
// voxels from one column to the next, and nothing is continuous.
//
// Ground scatters where, in a neighbourhood of 12 x 12 columns, tops stand out
// of their four neighbours' median, and as many lack in it: things on a floor
// only stand out, and steps and slopes do neither. There each height becomes
// the median of 5 x 5 columns, which keeps the edges of steps, and then the
// mean of those of 7 x 7 that are within a voxel of it. Heights more than
// four voxels off are none of the surface. Ground that does not scatter is left
// alone.
void SettleRoughGround(GroundColumns& ground);

// Of a rectangle that is this much larger each way, the middle comes out as of
// the whole map: neighbourhoods of tiles and the windows.
inline constexpr int kSettleReach = 14;

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_ROUGH_GROUND_H_
