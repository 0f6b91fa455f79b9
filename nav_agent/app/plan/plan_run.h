// What `treeline-agent plan` does: a map, a plan, its picture.
#ifndef NAV_AGENT_APP_PLAN_PLAN_RUN_H_
#define NAV_AGENT_APP_PLAN_PLAN_RUN_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "nav_agent/planning/global_planner.h"

namespace treeline::plan_app {

// "X,Y,YAW" or "X,Y,YAW,LEVEL" (m, rad). INVALID_ARGUMENT, with the option's
// name, for what is not.
absl::StatusOr<core::LevelPose> ParsePlanPose(const std::string& text,
                                              const std::string& option);
// "X,Y,RADIUS" or "X,Y,RADIUS,LEVEL" (m).
absl::StatusOr<planning::Blockage> ParseBlockage(const std::string& text);

// A map_server map (.yaml), or the folder of a map bundle.
absl::StatusOr<std::shared_ptr<const traversability::NavigationMap>>
LoadNavigationMap(const std::string& path, bool allow_unknown);
// Of a synthetic world, perfectly known.
absl::StatusOr<std::shared_ptr<const traversability::NavigationMap>>
NavigationMapOfWorld(const std::string& name, bool allow_unknown);

// What a plan is drawn and written from.
struct PlanReport {
  std::string map_name;
  std::string planner;
  planning::PlanRequest request;
  planning::PlanResult result;
};

std::string PlanJson(const PlanReport& report);
std::string PlanSummary(const PlanReport& report);

}  // namespace treeline::plan_app

#endif  // NAV_AGENT_APP_PLAN_PLAN_RUN_H_
