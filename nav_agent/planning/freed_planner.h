// Plans over what the map has and the robot saw to be gone.
#ifndef NAV_AGENT_PLANNING_FREED_PLANNER_H_
#define NAV_AGENT_PLANNING_FREED_PLANNER_H_

#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "nav_agent/planning/global_planner.h"

namespace treeline::planning {

// The planner of one map, as it is, with zones.
absl::StatusOr<std::unique_ptr<GlobalPlanner>> MakePlannerOfMap(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const GlobalPlannerOptions& options);

// For requests with freed cells that it has not had before, map and planner are
// made anew, in Plan: as long as making them for the map itself took.
class FreedPlanner final : public GlobalPlanner {
 public:
  // as_mapped: the planner for requests without such cells, of the same map.
  FreedPlanner(std::shared_ptr<const traversability::NavigationMap> map,
               const core::RobotModel& robot,
               const GlobalPlannerOptions& options,
               std::unique_ptr<const GlobalPlanner> as_mapped);

  absl::StatusOr<PlanResult> Plan(const PlanRequest& request,
                                  const PlanBudget& budget,
                                  const std::stop_token& stop) const override;

 private:
  struct Opened {
    std::shared_ptr<const traversability::FreedCells> freed;
    std::unique_ptr<const GlobalPlanner> planner;
  };

  absl::StatusOr<std::shared_ptr<const Opened>> OpenedFor(
      const std::shared_ptr<const traversability::FreedCells>& freed) const;

  const std::shared_ptr<const traversability::NavigationMap> map_;
  const core::RobotModel robot_;
  const GlobalPlannerOptions options_;
  const std::unique_ptr<const GlobalPlanner> as_mapped_;
  mutable absl::Mutex mutex_;
  // Of the last cells.
  mutable std::shared_ptr<const Opened> last_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_FREED_PLANNER_H_
