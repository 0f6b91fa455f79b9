#include "nav_agent/docking/dock_drive.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/docking/parameters.h"

namespace treeline::docking {
namespace {

// Of a robot that travels along a line, to its left and turned by that (1/m).
double CurvatureOnto(double aside_m, double turned_rad, double staging_m) {
  const double l_m = staging_m / kLinesInWay;
  return std::clamp(-aside_m / (l_m * l_m) - 2 * turned_rad / l_m,
                    -kMaxCurvature_pm.value, kMaxCurvature_pm.value);
}

double FastestOf(bool is_ahead, const core::RobotModel& robot) {
  return std::min(kDockSpeed_mps.value,
                  is_ahead ? robot.max_forward_mps : robot.max_backward_mps);
}

}  // namespace

core::VelocityCommand DriveIn(const Dock& dock, const DockOffset& off,
                              const core::RobotModel& robot) {
  const double fastest_mps = FastestOf(!dock.is_backward, robot);
  const double speed_mps =
      std::clamp(-kSpeedOfWay_ps * off.along_m,
                 std::min(kTouchSpeed_mps.value, fastest_mps), fastest_mps);
  return {.forward_mps = dock.is_backward ? -speed_mps : speed_mps,
          .yaw_rate_radps =
              speed_mps *
              CurvatureOnto(off.aside_m, off.turned_rad, dock.staging_m)};
}

core::VelocityCommand PressOn(const Dock& dock) {
  return {.forward_mps = dock.is_backward ? -kTouchSpeed_mps : kTouchSpeed_mps,
          .yaw_rate_radps = 0};
}

core::VelocityCommand DriveOut(const Dock& dock, const DockOffset& off,
                               const core::RobotModel& robot) {
  const double speed_mps = FastestOf(dock.is_backward, robot);
  return {.forward_mps = dock.is_backward ? speed_mps : -speed_mps,
          .yaw_rate_radps =
              speed_mps *
              CurvatureOnto(-off.aside_m, off.turned_rad, dock.staging_m)};
}

core::VelocityCommand TurnStraight(const DockOffset& off) {
  // Twice its own size a second: as fast as it may, and not beyond.
  return {
      .forward_mps = 0,
      .yaw_rate_radps = std::clamp(-2 * off.turned_rad, -kTurnSpeed_radps.value,
                                   kTurnSpeed_radps.value)};
}

}  // namespace treeline::docking
