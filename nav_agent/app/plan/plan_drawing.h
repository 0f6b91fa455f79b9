// The picture of a plan.
#ifndef NAV_AGENT_APP_PLAN_PLAN_DRAWING_H_
#define NAV_AGENT_APP_PLAN_PLAN_DRAWING_H_

#include "common/image/image.h"
#include "nav_agent/app/plan/plan_run.h"

namespace treeline::plan_app {

// All levels that the plan has to do with, side by side: free ground white,
// sloped ground green to yellow, occupied black, unknown grey; the start's tree
// blue, the goal's green, the path red; footprints where it starts (blue) and
// ends (green), dashed grey where they were asked for if that was moved;
// blockages orange. Below: what the colours mean, a scale, and the figures.
image::ColorImage DrawPlanReport(const traversability::NavigationMap& map,
                                 const core::RobotModel& robot,
                                 const PlanReport& report);

}  // namespace treeline::plan_app

#endif  // NAV_AGENT_APP_PLAN_PLAN_DRAWING_H_
