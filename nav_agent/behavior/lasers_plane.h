// Whether a laser sees over what stands somewhere, or into the ground before
// it.
#ifndef NAV_AGENT_BEHAVIOR_LASERS_PLANE_H_
#define NAV_AGENT_BEHAVIOR_LASERS_PLANE_H_

#include "common/geometry/rigid3.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/planning/global_planner.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::behavior {

// Whether the laser's plane passes through what stands on the ground at a
// blockage. On and before slopes the laser looks into the ground, or over what
// stands there.
bool IsInLasersPlane(const traversability::NavigationMap& map,
                     const control::ControlPose& pose,
                     const geometry::Rigid3& base_from_laser,
                     const planning::Blockage& blockage);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_LASERS_PLANE_H_
