#include "nav_agent/behavior/navigator.h"

#include <memory>
#include <utility>

#include "absl/status/statusor.h"
#include "common/base/status_macros.h"
#include "nav_agent/behavior/navigator_parts.h"
#include "nav_agent/behavior/planner_worker.h"

namespace treeline::behavior {
namespace {

std::unique_ptr<PlannerWorker> RunnerOf(
    std::unique_ptr<const planning::GlobalPlanner> planner,
    const NavigatorOptions& options) {
  if (options.plans_in_background) {
    return MakeThreadPlannerWorker(std::move(planner));
  }
  if (options.plan_steps > 0) {
    return MakeSteppedPlannerWorker(std::move(planner), options.plan_steps,
                                    1e3 / options.control_hz);
  }
  return MakeInlinePlannerWorker(std::move(planner));
}

core::RobotLasers LasersOf(const NavigatorDevices& devices) {
  core::RobotLasers lasers = {.front = devices.laser.Info()};
  if (devices.rear_laser != nullptr) lasers.rear = devices.rear_laser->Info();
  return lasers;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Navigator>> Navigator::Create(
    const NavigatorMap& map, const core::RobotModel& robot,
    const NavigatorDevices& devices, const NavigatorOptions& options,
    const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_RETURN_IF_ERROR(robot.Validate());
  const auto is_unknown = [](const core::RangeSensor& laser) {
    return laser.Health().state == core::DeviceState::kStarting &&
           laser.Info().beams == 0;
  };
  if (is_unknown(devices.laser) ||
      (devices.rear_laser != nullptr && is_unknown(*devices.rear_laser))) {
    return absl::FailedPreconditionError(
        "a laser has not said yet how it scans; wait until it runs");
  }
  NavigatorParts parts;
  TL_ASSIGN_OR_RETURN(
      traversability::NavigationMap levels,
      traversability::NavigationMap::Make(map.levels, options.map));
  parts.map =
      std::make_shared<const traversability::NavigationMap>(std::move(levels));
  TL_ASSIGN_OR_RETURN(
      std::unique_ptr<planning::GlobalPlanner> planner,
      planning::MakeGlobalPlanner(parts.map, robot, options.planner));
  parts.planner = RunnerOf(std::move(planner), options);
  const core::RangeSensorInfo laser = devices.laser.Info();
  TL_ASSIGN_OR_RETURN(parts.controller, control::LocalController::Make(
                                            parts.map, robot, LasersOf(devices),
                                            options.control));
  TL_ASSIGN_OR_RETURN(parts.tracker, localization::RobotTracker::Create(
                                         map.voxels, map.levels, robot, laser,
                                         options.tracker, options.seed));
  TL_ASSIGN_OR_RETURN(parts.lost, RelocalizationBehavior::Create(
                                      parts.map, robot, *parts.tracker,
                                      devices.server, options.lost));
  return AssembleNavigator(std::move(parts), robot, devices, options, clock);
}

}  // namespace treeline::behavior
