// Plans beside the control loop, or within it.
#ifndef NAV_AGENT_BEHAVIOR_PLANNER_WORKER_H_
#define NAV_AGENT_BEHAVIOR_PLANNER_WORKER_H_

#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "nav_agent/planning/global_planner.h"

namespace treeline::behavior {

// Processor time of plans (ms).
struct PlanTally {
  int plans = 0;
  double total_ms = 0;
  double longest_ms = 0;
  // Handed over later than they would have been by the processor alone: see
  // MakeSteppedPlannerWorker.
  int late = 0;

  void Add(double plan_ms);
  void Add(const PlanTally& other);
};

// Makes one plan at a time. Called by one thread.
class PlannerWorker {
 public:
  virtual ~PlannerWorker() = default;

  // Begins; what is being planned is given up, and no result of it comes.
  virtual void Start(const planning::PlanRequest& request,
                     const planning::PlanBudget& budget) = 0;
  // The result, once; nullopt while there is none.
  virtual std::optional<absl::StatusOr<planning::PlanResult>> Take() = 0;
  // Between Start and the Take that hands over the result, or Cancel.
  virtual bool IsBusy() const = 0;
  virtual void Cancel() = 0;
  // A step of the control loop begins: for those that count them.
  virtual void BeginStep() {}
  // Of the plans that came to their end.
  virtual PlanTally Tally() const = 0;
};

// Plans within Start: the next Take has the result.
std::unique_ptr<PlannerWorker> MakeInlinePlannerWorker(
    std::unique_ptr<const planning::GlobalPlanner> planner);

// Plans in a thread of its own; no call waits for it, but for the destructor,
// which waits until the planner has noticed that it is to stop.
std::unique_ptr<PlannerWorker> MakeThreadPlannerWorker(
    std::unique_ptr<const planning::GlobalPlanner> planner);

// The same, but a result comes exactly `steps` (at least 1) steps after its
// plan was begun, so that a run depends on its seed and not on the machine. Of
// a plan that takes longer, Take waits for the end. `late` are plans that took
// more processor time than the steps, of step_ms each: there a robot that does
// not wait would have had its plan later.
std::unique_ptr<PlannerWorker> MakeSteppedPlannerWorker(
    std::unique_ptr<const planning::GlobalPlanner> planner, int steps,
    double step_ms);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PLANNER_WORKER_H_
