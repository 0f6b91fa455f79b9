// What the robot's devices tell: plain values, stamped with the clock of the
// machine that drives (monotonic), at the moment of measurement rather than of
// arrival. Frames: docs/frames.md.
#ifndef NAV_AGENT_CORE_SENSOR_DATA_H_
#define NAV_AGENT_CORE_SENSOR_DATA_H_

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "common/base/clock.h"
#include "common/image/frame.h"

namespace treeline::core {

// The geometry of a planar laser scanner's scans (sensor_msgs/LaserScan).
struct RangeSensorInfo {
  // Of the first beam, and from one to the next; counter-clockwise in the laser
  // frame (x forward, y left).
  double angle_min_rad = 0;
  double angle_increment_rad = 0;
  int beams = 0;
  // Measurements outside are invalid.
  double range_min_m = 0;
  double range_max_m = 0;
  // From one beam to the next, and from one scan to the next.
  double beam_interval_s = 0;
  double scan_interval_s = 0;

  constexpr bool operator==(const RangeSensorInfo&) const = default;
  double AngleOf_rad(int beam) const {
    return angle_min_rad + beam * angle_increment_rad;
  }
};

// Those of a robot; rear: nullopt if none looks back.
struct RobotLasers {
  RangeSensorInfo front;
  std::optional<RangeSensorInfo> rear = std::nullopt;
};

// Ranges that are none (REP 117).
inline constexpr float kNoReturn = std::numeric_limits<float>::infinity();
inline constexpr float kTooNear = -std::numeric_limits<float>::infinity();
inline constexpr float kInvalidRange = std::numeric_limits<float>::quiet_NaN();

struct LaserScan {
  // When the first beam was measured.
  base::MonotonicTime stamp;
  // One for each beam (m), or one of the three above.
  std::vector<float> ranges_m;
  // One for each beam, in the sensor's own units; or empty.
  std::vector<uint16_t> intensities;
};

struct RgbdFrame {
  // The middle of the exposure.
  base::MonotonicTime stamp;
  // Numbers exposures from 0 upwards; a gap is a frame that was lost.
  int64_t sequence = 0;
  image::Frame frame;
};

// What wheels and inertial sensor of a differential drive say.
struct BaseReading {
  base::MonotonicTime stamp;
  // How far each wheel has rolled since the base was switched on or its
  // counters were reset. Only differences mean anything.
  double left_wheel_m = 0;
  double right_wheel_m = 0;
  // Speed over ground along the robot's x axis, and about its z axis.
  double forward_mps = 0;
  double yaw_rate_radps = 0;
  // Of the inertial sensor: nose down is positive pitch, right side down is
  // positive roll (rotations about y and x, REP 103).
  double pitch_rad = 0;
  double roll_rad = 0;
  double pitch_rate_radps = 0;
  double roll_rate_radps = 0;
  // 0 where the base does not tell.
  double battery_v = 0;
  bool motors_enabled = true;
};

// What a base is asked to do until the next command, or until it is too old.
struct VelocityCommand {
  double forward_mps = 0;
  double yaw_rate_radps = 0;

  constexpr bool operator==(const VelocityCommand&) const = default;
};

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_SENSOR_DATA_H_
