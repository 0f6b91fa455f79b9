// The table of this folder's tuned constants.
#ifndef NAV_AGENT_PLANNING_PARAMETERS_H_
#define NAV_AGENT_PLANNING_PARAMETERS_H_

#include <vector>

#include "common/base/parameter.h"

namespace treeline::planning {

// All of planner_parameters.h, in its order.
std::vector<base::ParameterRow> PlanningParameters();

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_PARAMETERS_H_
