#include "nav_agent/app/run/navigator_setup.h"

#include <cstdint>

#include "nav_agent/behavior/parameters.h"
#include "nav_agent/localization/odometry_motion.h"

namespace treeline::run_app {
namespace {

// On the robot's clock: who drives by hand lives in real time.
double ManualLease_s(const AgentConfig& config) {
  return behavior::kManualLease_s * config.speed;
}

}  // namespace

behavior::NavigatorOptions NavigatorOptionsOf(const AgentConfig& config,
                                              AgentRobot& robot) {
  behavior::NavigatorOptions options;
  options.control_hz = kControlHz;
  options.plans_in_background = true;
  options.planner.planner = config.planner;
  options.first_plan_budget.max_time_s = 0.5;
  options.plan_budget.max_time_s = 0.5;
  options.control.max_forward_mps = config.max_forward_mps;
  options.control.inflation_m = config.inflation_m;
  options.control.goal_tolerance_m = config.goal_tolerance_m;
  options.control.goal_tolerance_rad = config.goal_tolerance_rad;
  options.laser_timeout_s = config.laser_timeout_s;
  options.odometry_timeout_s = config.odometry_timeout_s;
  options.finds_itself_at_start = config.find_yourself;
  options.seed = static_cast<uint64_t>(config.seed);
  options.manual_lease_s = ManualLease_s(config);
  if (const auto noise = robot.noise(); noise.has_value()) {
    options.tracker.amcl.odometry = localization::OdometryNoise::Of(*noise);
  }
  return options;
}

mapless::MaplessOptions SightOptionsOf(const AgentConfig& config) {
  mapless::MaplessOptions options;
  options.control_hz = kControlHz;
  options.max_forward_mps = config.max_forward_mps;
  options.goal_tolerance_m = config.goal_tolerance_m;
  options.goal_tolerance_rad = config.goal_tolerance_rad;
  options.laser_timeout_s = config.laser_timeout_s;
  options.odometry_timeout_s = config.odometry_timeout_s;
  options.manual_lease_s = ManualLease_s(config);
  return options;
}

}  // namespace treeline::run_app
