// Plans that respect zones, whichever planner makes them.
#ifndef NAV_AGENT_PLANNING_ZONE_PLANNER_H_
#define NAV_AGENT_PLANNING_ZONE_PLANNER_H_

#include <memory>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "nav_agent/planning/global_planner.h"
#include "nav_agent/planning/plan_frame.h"

namespace treeline::planning {

// The planner that GlobalPlannerOptions names, on one ground, without zones but
// those of the ground. INVALID_ARGUMENT: there is no such planner.
absl::StatusOr<std::unique_ptr<GlobalPlanner>> MakePlannerOn(
    std::shared_ptr<const PlanGround> ground, const core::RobotModel& robot,
    const GlobalPlannerOptions& options);

// What is kept out of is blocked for the planner within. A robot that stands in
// it is first led out of it, the shortest way, to where a way leads on to the
// goal. Failures by zones alone have the cause kZone. For zones that it has not
// had before, ground and planner are made anew, in Plan: as long as making them
// for the map itself took.
class ZonePlanner final : public GlobalPlanner {
 public:
  // without: the planner for requests without zones, of the same map.
  ZonePlanner(std::shared_ptr<const traversability::NavigationMap> map,
              const core::RobotModel& robot,
              const GlobalPlannerOptions& options,
              std::unique_ptr<const GlobalPlanner> without);

  absl::StatusOr<PlanResult> Plan(const PlanRequest& request,
                                  const PlanBudget& budget,
                                  const std::stop_token& stop) const override;

 private:
  // A map with zones, and what plans on it.
  struct Zoned {
    std::shared_ptr<const zones::ZoneMap> zones;
    std::shared_ptr<const PlanGround> ground;
    std::unique_ptr<const GlobalPlanner> planner;
  };

  absl::StatusOr<std::shared_ptr<const Zoned>> ZonedFor(
      const std::shared_ptr<const zones::ZoneMap>& zones) const;
  absl::StatusOr<PlanResult> PlanOn(const Zoned& zoned,
                                    const PlanRequest& request,
                                    const PlanBudget& budget,
                                    const std::stop_token& stop) const;
  absl::StatusOr<PlanResult> PlanOut(const Zoned& zoned,
                                     const PlanRequest& request,
                                     const PlanBudget& budget,
                                     const std::stop_token& stop) const;
  // Sets the cause of a failure that there would not be without zones.
  absl::Status Blame(const Zoned& zoned, const PlanRequest& request,
                     const PlanBudget& budget, const std::stop_token& stop,
                     PlanResult& result) const;

  const std::shared_ptr<const traversability::NavigationMap> map_;
  const core::RobotModel robot_;
  const GlobalPlannerOptions options_;
  const std::unique_ptr<const GlobalPlanner> without_;
  mutable absl::Mutex mutex_;
  // Of the last zones.
  mutable std::shared_ptr<const Zoned> last_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_ZONE_PLANNER_H_
