#include "nav_agent/planning/freed_planner.h"

#include <utility>

#include "common/base/status_macros.h"

namespace treeline::planning {

FreedPlanner::FreedPlanner(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const GlobalPlannerOptions& options,
    std::unique_ptr<const GlobalPlanner> as_mapped)
    : map_(std::move(map)),
      robot_(robot),
      options_(options),
      as_mapped_(std::move(as_mapped)) {}

absl::StatusOr<std::shared_ptr<const FreedPlanner::Opened>>
FreedPlanner::OpenedFor(
    const std::shared_ptr<const traversability::FreedCells>& freed) const {
  {
    const absl::MutexLock lock(&mutex_);
    if (last_ != nullptr && last_->freed == freed) return last_;
  }
  auto opened = std::make_shared<Opened>();
  opened->freed = freed;
  TL_ASSIGN_OR_RETURN(traversability::NavigationMap map,
                      traversability::MapWithFreed(*map_, *freed));
  TL_ASSIGN_OR_RETURN(
      opened->planner,
      MakePlannerOfMap(
          std::make_shared<const traversability::NavigationMap>(std::move(map)),
          robot_, options_));
  const absl::MutexLock lock(&mutex_);
  last_ = opened;
  return last_;
}

absl::StatusOr<PlanResult> FreedPlanner::Plan(
    const PlanRequest& request, const PlanBudget& budget,
    const std::stop_token& stop) const {
  if (request.freed == nullptr || request.freed->empty()) {
    return as_mapped_->Plan(request, budget, stop);
  }
  TL_ASSIGN_OR_RETURN(const std::shared_ptr<const Opened> opened,
                      OpenedFor(request.freed));
  return opened->planner->Plan(request, budget, stop);
}

}  // namespace treeline::planning
