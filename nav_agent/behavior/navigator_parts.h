// What a navigator is put together from; tests put in others.
#ifndef NAV_AGENT_BEHAVIOR_NAVIGATOR_PARTS_H_
#define NAV_AGENT_BEHAVIOR_NAVIGATOR_PARTS_H_

#include <memory>

#include "absl/status/statusor.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/behavior/planner_worker.h"

namespace treeline::behavior {

struct NavigatorParts {
  std::shared_ptr<const traversability::NavigationMap> map;
  std::unique_ptr<PlannerWorker> planner;
  std::unique_ptr<control::LocalController> controller;
  std::unique_ptr<localization::RobotTracker> tracker;
  // Knows the tracker.
  std::unique_ptr<RelocalizationBehavior> lost;
};

// As Navigator::Create, which makes the parts.
absl::StatusOr<std::unique_ptr<Navigator>> AssembleNavigator(
    NavigatorParts parts, const core::RobotModel& robot,
    const NavigatorDevices& devices, const NavigatorOptions& options,
    const base::Clock& clock);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_NAVIGATOR_PARTS_H_
