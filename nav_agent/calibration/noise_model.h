// How wrong odometry is.
#ifndef NAV_AGENT_CALIBRATION_NOISE_MODEL_H_
#define NAV_AGENT_CALIBRATION_NOISE_MODEL_H_

#include <optional>
#include <span>

#include "nav_agent/core/odometry_noise.h"

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
// found on a grid of steps of a fifth and then of 3 %, not below kNoiseFloor.
// Errors are in the order of the drive: their sigma is that of leaving out one
// of kBlocks parts of it at a time (jackknife), as neighbouring errors are not
// independent.
struct NoiseFit {
  core::MeasuredOdometryNoise noise;
  core::MeasuredOdometryNoise sigma;
};
// nullopt: there are not both turns and straight motions.
std::optional<NoiseFit> FitNoise(std::span<const MotionError> errors);

// How much larger the errors are than `noise` says, of yaw and along: 1 if it
// fits. The root of their mean square in standard deviations; without errors 0.
struct NoiseExcess {
  double yaw = 0;
  double along = 0;
};
NoiseExcess ExcessOver(const core::MeasuredOdometryNoise& noise,
                       std::span<const MotionError> errors);

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_NOISE_MODEL_H_
