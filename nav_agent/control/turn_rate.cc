#include "nav_agent/control/turn_rate.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/control/driving_parameters.h"

namespace treeline::control {

double TurnOnSpotRate_radps(double angle_rad, const core::RobotModel& robot) {
  const double left_rad = std::abs(angle_rad);
  if (left_rad < kTurned_rad) return 0;
  const double brake =
      kYawShare * kAccelerationShare * robot.max_yaw_acceleration_radps2;
  // Near the end in proportion, so that lateness does not make it swing.
  const double rate =
      std::min({kYawShare * robot.max_yaw_rate_radps,
                std::sqrt(2 * brake * left_rad), kTurnGain_hz * left_rad});
  return std::copysign(rate, angle_rad);
}

}  // namespace treeline::control
