// Plans beside the control loop, or within it.
#ifndef NAV_AGENT_BEHAVIOR_PLAN_RUNNER_H_
#define NAV_AGENT_BEHAVIOR_PLAN_RUNNER_H_

#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "nav_agent/planning/global_planner.h"

namespace treeline {

// Makes one plan at a time. Called by one thread.
class PlanRunner {
 public:
  virtual ~PlanRunner() = default;

  // Begins; what is being planned is given up, and no result of it comes.
  virtual void Start(const PlanRequest& request, const PlanBudget& budget) = 0;
  // The result, once; nullopt while there is none.
  virtual std::optional<absl::StatusOr<PlanResult>> Take() = 0;
  // Between Start and the Take that hands over the result, or Cancel.
  virtual bool IsBusy() const = 0;
  virtual void Cancel() = 0;
};

// Plans within Start: the next Take has the result.
std::unique_ptr<PlanRunner> MakeInlinePlanRunner(
    std::unique_ptr<const GlobalPlanner> planner);

// Plans in a thread of its own; no call waits for it, but for the destructor,
// which waits until the planner has noticed that it is to stop.
std::unique_ptr<PlanRunner> MakeThreadPlanRunner(
    std::unique_ptr<const GlobalPlanner> planner);

}  // namespace treeline

#endif  // NAV_AGENT_BEHAVIOR_PLAN_RUNNER_H_
