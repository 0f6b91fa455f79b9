// How long a plan takes.
#ifndef NAV_AGENT_PLANNING_PLAN_CLOCK_H_
#define NAV_AGENT_PLANNING_PLAN_CLOCK_H_

#include "common/base/clock.h"
#include "nav_agent/planning/global_planner.h"

namespace treeline::planning {

inline const base::Clock& ClockOf(const PlanBudget& budget) {
  static const base::SteadyClock steady;
  return budget.clock == nullptr ? steady : *budget.clock;
}

inline double SecondsSince(base::MonotonicTime start) {
  return base::SecondsBetween(start, base::SteadyClock().Now());
}

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_PLAN_CLOCK_H_
