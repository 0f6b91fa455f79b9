// Planners of OMPL behind our interface.
#ifndef NAV_AGENT_PLANNING_OMPL_PLANNER_H_
#define NAV_AGENT_PLANNING_OMPL_PLANNER_H_

#include <memory>
#include <string>

#include "nav_agent/planning/global_planner.h"
#include "nav_agent/planning/plan_frame.h"

namespace treeline::planning {

// Whether there is such a planner: "rrt-connect", "rrt-star", "bit-star",
// "informed-rrt-star", "ompl-variable-rrt".
bool IsOmplPlanner(const std::string& name);

// States are places where the robot can turn right round; motions are straight
// lines, swept with the footprint. So what OMPL finds can be driven, but
// places too narrow to turn in are passed in straight lines only. A start or
// goal where the robot cannot turn is left (come to) straight ahead. Planners
// that improve their path do so until the budget ends; what the others find is
// cut short as our own planner does.
//
// OMPL's random numbers come from one generator of the process: plans run one
// at a time.
class OmplPlanner final : public GlobalPlanner {
 public:
  OmplPlanner(std::shared_ptr<const PlanGround> ground, std::string name,
              double max_move_m);

  absl::StatusOr<PlanResult> Plan(const PlanRequest& request,
                                  const PlanBudget& budget,
                                  const std::stop_token& stop) const override;

 private:
  std::shared_ptr<const PlanGround> ground_;
  std::string name_;
  double max_move_m_;
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_OMPL_PLANNER_H_
