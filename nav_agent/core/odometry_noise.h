// How wrong a robot's odometry was measured to be.
#ifndef NAV_AGENT_CORE_ODOMETRY_NOISE_H_
#define NAV_AGENT_CORE_ODOMETRY_NOISE_H_

#include <array>
#include <optional>

#include "absl/status/statusor.h"

namespace treeline::core {

// One standard deviation of what odometry errs over a stretch of about half a
// metre or 20 degrees, as shares of its turn and its way:
//
//   yaw (rad):   turn_from_turn |turn| + turn_from_drive way
//   along (m):   drive_from_drive way + drive_from_turn |turn|
//
// (Probabilistic Robotics, table 5.6), as `treeline-agent calibrate` finds it.
// A property of the robot and its floor. Whoever relies on it takes it with a
// margin of his own.
struct MeasuredOdometryNoise {
  // rad per rad, rad per m, m per m, m per rad; kLeastNoise to kMostNoise.
  double turn_from_turn = 0;
  double turn_from_drive = 0;
  double drive_from_drive = 0;
  double drive_from_turn = 0;

  constexpr bool operator==(const MeasuredOdometryNoise&) const = default;
};

// No odometry is better than the least; wheels that are off by the most tell
// nothing.
inline constexpr double kLeastNoise = 0.001;
inline constexpr double kMostNoise = 1;

// The four as files name them.
struct NoiseKey {
  const char* name;
  double MeasuredOdometryNoise::*value;
};
inline constexpr std::array<NoiseKey, 4> kNoiseKeys = {
    {{"turn_from_turn", &MeasuredOdometryNoise::turn_from_turn},
     {"turn_from_drive", &MeasuredOdometryNoise::turn_from_drive},
     {"drive_from_drive", &MeasuredOdometryNoise::drive_from_drive},
     {"drive_from_turn", &MeasuredOdometryNoise::drive_from_turn}}};

// What a file says, 0 for what it does not say. nullopt: it says nothing.
// INVALID_ARGUMENT if some of the four are missing, or one is out of bounds.
absl::StatusOr<std::optional<MeasuredOdometryNoise>> NoiseOfFile(
    const MeasuredOdometryNoise& told);

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_ODOMETRY_NOISE_H_
