// Where the wheels were a moment ago.
#ifndef NAV_AGENT_LOCALIZATION_ODOMETRY_BUFFER_H_
#define NAV_AGENT_LOCALIZATION_ODOMETRY_BUFFER_H_

#include <deque>
#include <optional>

#include "absl/status/status.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/core/slope_odometry.h"
#include "nav_agent/localization/robot_tracker.h"

namespace treeline::localization {

// The way so far, and the tilt, smoothed over about five readings (rad).
struct BufferedOdometry {
  TrackedMotion motion;
  double pitch_rad = 0;
  double roll_rad = 0;
};

// The last 2.5 s of them. Deterministic; not thread-safe.
class OdometryBuffer {
 public:
  explicit OdometryBuffer(core::SlopeOdometry odometry) : odometry_(odometry) {}

  // Errors as SlopeOdometry's.
  absl::Status Add(const core::BaseReading& reading);

  bool is_empty() const { return moments_.empty(); }
  // There must be one.
  const BufferedOdometry& newest() const { return moments_.back(); }
  // At a moment that is remembered, between two readings; the newest for what
  // is newer by 0.05 s at most.
  std::optional<BufferedOdometry> At(base::MonotonicTime stamp) const;

 private:
  core::SlopeOdometry odometry_;
  // The oldest first.
  std::deque<BufferedOdometry> moments_;
  double pitch_rad_ = 0;
  double roll_rad_ = 0;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_ODOMETRY_BUFFER_H_
