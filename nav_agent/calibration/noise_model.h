// How wrong odometry is, as the robot's particle filter takes it.
#ifndef NAV_AGENT_CALIBRATION_NOISE_MODEL_H_
#define NAV_AGENT_CALIBRATION_NOISE_MODEL_H_

#include <optional>
#include <span>

#include "nav_agent/localization/odometry_motion.h"

namespace treeline::calibration {

// A motion and what odometry erred in it: along the way (m) and in yaw (rad).
struct MotionError {
  double way_m = 0;
  double turn_rad = 0;
  double along_m = 0;
  double yaw_rad = 0;
};

// The most likely shares: errors are normal, with standard deviations
//
//   yaw: turn_from_turn |turn| + turn_from_drive way
//   along: drive_from_drive way + drive_from_turn |turn|
//
// found on a grid of steps of a fifth, not below kNoiseFloor. nullopt: there
// are not both turns and straight motions.
std::optional<localization::OdometryNoise> FitNoise(
    std::span<const MotionError> errors);

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_NOISE_MODEL_H_
