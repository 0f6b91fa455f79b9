// The shape of something that stands in the way, as discs.
#ifndef NAV_AGENT_BEHAVIOR_OBSTACLE_DISCS_H_
#define NAV_AGENT_BEHAVIOR_OBSTACLE_DISCS_H_

#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/control/local_controller.h"
#include "nav_agent/planning/global_planner.h"

namespace treeline::behavior {

// What was seen (cells 2 of the costmap) near `about` and hangs together with
// it: no gap is wide enough for a robot. One disc of radius_m every fifth of a
// metre, each with another one behind it as seen from `eye`, since only faces
// are seen. One disc at `about`, of fallback_radius_m, where nothing was.
std::vector<planning::Blockage> DiscsOf(const control::CostmapView& costmap,
                                        geometry::Vec2 about,
                                        geometry::Vec2 eye, double radius_m,
                                        double fallback_radius_m, int level);

// Whether the costmap shows something seen within reach_m of a point.
bool IsSeenNear(const control::CostmapView& costmap, geometry::Vec2 about,
                double reach_m);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_OBSTACLE_DISCS_H_
