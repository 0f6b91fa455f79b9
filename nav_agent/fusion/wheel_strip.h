// The strip of ground that the wheels stood on.
#ifndef NAV_AGENT_FUSION_WHEEL_STRIP_H_
#define NAV_AGENT_FUSION_WHEEL_STRIP_H_

#include <span>

#include "common/geometry/rigid3.h"
#include "nav_agent/octomap/voxel_map.h"

namespace treeline::fusion {

// What was driven on is ground, even if no view shows it: a camera that looks
// ahead does not see what the robot stands on, nor the floor of a place that it
// only turns in. What was seen of a hole's edges from afar may be a voxel off,
// on each side the other way.
//
// Holes are columns below the axle with nothing occupied within a voxel of the
// wheels' height. There, and on the strip within 0.3 m of them, the ground is
// put to that height: its voxel becomes occupied, and free what is up to three
// voxels above. All else stays as it was seen. Outside of the map's box nothing
// is put.
//
// map_from_base: on the ground below the axle's middle, y along it, no further
// apart than a voxel. half_width_m: from there to the outer edge of each wheel.
// Returns how many columns were holes.
int FillWheelStrip(std::span<const geometry::Rigid3> map_from_base,
                   double half_width_m, octree::VoxelMap& map);

}  // namespace treeline::fusion

#endif  // NAV_AGENT_FUSION_WHEEL_STRIP_H_
