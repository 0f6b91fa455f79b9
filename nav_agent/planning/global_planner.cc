#include "nav_agent/planning/global_planner.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/planning/freed_planner.h"
#include "nav_agent/planning/ompl_planner.h"
#include "nav_agent/planning/plan_frame.h"
#include "nav_agent/planning/variable_rrt_planner.h"
#include "nav_agent/planning/zone_planner.h"

namespace treeline::planning {
namespace {

constexpr char kPlanners[] =
    "variable-rrt, and of OMPL rrt-connect, rrt-star, bit-star, "
    "informed-rrt-star, ompl-variable-rrt";

}  // namespace

absl::Status GlobalPlannerOptions::Validate() const {
  if (!(margin_m >= 0 && margin_m <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("margin_m must be in [0, 1], not ", margin_m));
  }
  if (!(max_move_m >= 0 && max_move_m <= 5)) {
    return absl::InvalidArgumentError(
        absl::StrCat("max_move_m must be in [0, 5], not ", max_move_m));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<GlobalPlanner>> MakePlannerOn(
    std::shared_ptr<const PlanGround> ground, const core::RobotModel& robot,
    const GlobalPlannerOptions& options) {
  if (options.planner == "variable-rrt") {
    auto tight = std::make_shared<const PlanGround>(ground->index, robot, 0.0);
    return std::make_unique<VariableRrtPlanner>(
        std::move(ground), std::move(tight), options.max_move_m);
  }
  if (IsOmplPlanner(options.planner)) {
    return std::make_unique<OmplPlanner>(std::move(ground), options.planner,
                                         options.max_move_m);
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "there is no planner '", options.planner, "'; there are: ", kPlanners));
}

absl::StatusOr<std::unique_ptr<GlobalPlanner>> MakePlannerOfMap(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const GlobalPlannerOptions& options) {
  auto ground =
      std::make_shared<const PlanGround>(map, robot, options.margin_m);
  TL_ASSIGN_OR_RETURN(std::unique_ptr<GlobalPlanner> without,
                      MakePlannerOn(std::move(ground), robot, options));
  return std::make_unique<ZonePlanner>(std::move(map), robot, options,
                                       std::move(without));
}

absl::StatusOr<std::unique_ptr<GlobalPlanner>> MakeGlobalPlanner(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const GlobalPlannerOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(robot.Validate());
  TL_ASSIGN_OR_RETURN(std::unique_ptr<GlobalPlanner> as_mapped,
                      MakePlannerOfMap(map, robot, options));
  return std::make_unique<FreedPlanner>(std::move(map), robot, options,
                                        std::move(as_mapped));
}

}  // namespace treeline::planning
