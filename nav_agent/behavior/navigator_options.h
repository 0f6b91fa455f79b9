// All that can be set of the supervisor and of what it is put together from.
#ifndef NAV_AGENT_BEHAVIOR_NAVIGATOR_OPTIONS_H_
#define NAV_AGENT_BEHAVIOR_NAVIGATOR_OPTIONS_H_

#include <cstdint>

#include "absl/status/status.h"
#include "nav_agent/behavior/navigator_limits.h"
#include "nav_agent/behavior/parameters.h"
#include "nav_agent/behavior/relocalization_behavior.h"
#include "nav_agent/control/local_controller.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/planning/global_planner.h"

namespace treeline::behavior {

struct NavigatorOptions {
  traversability::NavigationMapOptions map;
  planning::GlobalPlannerOptions planner;
  // The first path is found within the first budget; the robot sets off, and a
  // better one is looked for within the second.
  planning::PlanBudget first_plan_budget = {.max_iterations =
                                                kFirstPlanIterations};
  planning::PlanBudget plan_budget = {.max_iterations = kPlanIterations};
  // Plans are made by a thread of their own, so that Step never waits for one;
  // results then depend on the machine's speed.
  bool plans_in_background = false;
  // Or by such a thread, but handed over exactly so many steps after they were
  // begun (0 to 400; 0: not so), which Step waits for if it must: results do
  // not depend on the machine, and other than without both Step does nothing
  // of a plan's work. Not with plans_in_background.
  int plan_steps = 0;
  control::LocalControllerOptions control;
  localization::RobotTrackerOptions tracker;
  RelocalizationBehaviorOptions lost;
  NavigatorLimits limits;
  // Steps in a second (10 to 200).
  double control_hz = kControlRate_hz;
  // Devices that are silent for longer are lost (s, 0.05 to 5).
  double laser_timeout_s = kLaserTimeout_s;
  double odometry_timeout_s = kOdometryTimeout_s;
  // Depth pictures in a second that obstacles are taken from (0 to 30; 0:
  // none). A lost robot takes them as often, at least once a second.
  double depth_hz = control::kDepthRate_hz;
  // Whether a robot that was not told where it is looks for itself, rather than
  // waiting to be told.
  bool finds_itself_at_start = false;
  uint64_t seed = 0;
  // For how long a command of somebody who drives by hand is good, on the
  // navigator's clock (s, 0.001 to 1000): longer where that runs faster than
  // theirs, in simulations.
  double manual_lease_s = kManualLease_s;

  // INVALID_ARGUMENT names the field.
  absl::Status Validate() const;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_NAVIGATOR_OPTIONS_H_
