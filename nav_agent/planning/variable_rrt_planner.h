// Our own global planner.
#ifndef NAV_AGENT_PLANNING_VARIABLE_RRT_PLANNER_H_
#define NAV_AGENT_PLANNING_VARIABLE_RRT_PLANNER_H_

#include <memory>

#include "nav_agent/planning/global_planner.h"
#include "nav_agent/planning/plan_frame.h"

namespace treeline::planning {

class VariableRrtPlanner final : public GlobalPlanner {
 public:
  // Where `ground` has no way, one is looked for on `tight`: the same with no
  // room beside the footprint.
  VariableRrtPlanner(std::shared_ptr<const PlanGround> ground,
                     std::shared_ptr<const PlanGround> tight,
                     double max_move_m);

  absl::StatusOr<PlanResult> Plan(const PlanRequest& request,
                                  const PlanBudget& budget,
                                  const std::stop_token& stop) const override;

 private:
  std::shared_ptr<const PlanGround> ground_;
  std::shared_ptr<const PlanGround> tight_;
  double max_move_m_;
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_VARIABLE_RRT_PLANNER_H_
