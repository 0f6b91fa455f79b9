// What a robot could do where it stands, of what is known.
#ifndef NAV_AGENT_CONTROL_FREE_ROOM_H_
#define NAV_AGENT_CONTROL_FREE_ROOM_H_

#include "common/geometry/rigid2.h"
#include "nav_agent/control/local_costmap.h"

namespace treeline::control {

// Whether the footprint can turn fully with kFreeRoom_m beside it. Where it
// stands too near to something already, it must not get nearer by more than
// kMaxApproach_m.
bool CanTurnAt(const geometry::Rigid2& map_from_base,
               const LocalCostmap& costmap);

// How far it can move straight ahead so, max_distance_m or less (negative:
// back).
double FreeWayAt_m(const geometry::Rigid2& map_from_base, double max_distance_m,
                   const LocalCostmap& costmap);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_FREE_ROOM_H_
