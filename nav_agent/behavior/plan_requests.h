// What the planner is asked for a goal: one plan at a time, and what it is for.
#ifndef NAV_AGENT_BEHAVIOR_PLAN_REQUESTS_H_
#define NAV_AGENT_BEHAVIOR_PLAN_REQUESTS_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/behavior/navigator_options.h"
#include "nav_agent/behavior/planner_worker.h"

namespace treeline::behavior {

enum class PlanPurpose : uint8_t {
  kRoute,      // the first path
  kFullRoute,  // the same, with more time
  kUnblocked,  // whether there is a way but for what was seen
  kBetter,     // a shorter one, while driving
  kNextLeg     // to the pose after the next, while driving
};

// Not thread-safe. The planner must outlive it, and be used by it alone.
class PlanRequests {
 public:
  PlanRequests(PlannerWorker& planner, const NavigatorOptions& options)
      : planner_(planner),
        first_budget_(options.first_plan_budget),
        full_budget_(options.plan_budget),
        max_plan_s_(options.limits.plan_s),
        seed_(options.seed) {}

  // Of all plans from now on; null: none.
  void SetZones(std::shared_ptr<const zones::ZoneMap> zones) {
    zones_ = std::move(zones);
  }
  // Likewise, of what of the map is gone; null: nothing. Whether it is other
  // than before.
  bool SetFreed(std::shared_ptr<const traversability::FreedCells> freed) {
    if (freed == freed_) return false;
    freed_ = std::move(freed);
    return true;
  }
  // Gives up what was asked before. blockages: what stands about; a plan of
  // kUnblocked is not told of it.
  void Ask(PlanPurpose purpose, const core::LevelPose& from,
           const core::LevelPose& to, std::vector<planning::Blockage> blockages,
           base::MonotonicTime now);
  bool IsOpen() const { return asked_.has_value(); }
  void Cancel();

  struct Answer {
    PlanPurpose purpose = PlanPurpose::kRoute;
    bool had_blockages = false;
    absl::StatusOr<planning::PlanResult> result;

    // Whether the planner found a path.
    bool HasPath() const;
  };
  // The answer to what is open, once; nullopt while there is none.
  std::optional<Answer> Take();
  // The same for a robot that waits: a plan that takes too long is given up,
  // and has failed (kPlanTimeout).
  std::optional<Answer> TakeInTime(base::MonotonicTime now);

 private:
  struct Asked {
    PlanPurpose purpose = PlanPurpose::kRoute;
    base::MonotonicTime since;
    bool has_blockages = false;
  };

  PlannerWorker& planner_;
  planning::PlanBudget first_budget_;
  planning::PlanBudget full_budget_;
  double max_plan_s_;
  uint64_t seed_;
  uint64_t plans_ = 0;
  std::shared_ptr<const zones::ZoneMap> zones_;
  std::shared_ptr<const traversability::FreedCells> freed_;
  std::optional<Asked> asked_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PLAN_REQUESTS_H_
