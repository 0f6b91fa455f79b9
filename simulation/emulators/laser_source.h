// What an emulated laser sees.
#ifndef SIMULATION_EMULATORS_LASER_SOURCE_H_
#define SIMULATION_EMULATORS_LASER_SOURCE_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/clock.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::emulators {

class LaserSource {
 public:
  virtual ~LaserSource() = default;
  // The scan whose first beam is measured at `start`, with all beams of
  // `info`; ranges as in LaserScan (m, or REP 117's), intensities or none.
  virtual core::LaserScan ScanAt(base::MonotonicTime start,
                                 const core::RangeSensorInfo& info) = 0;
};

// A rectangular room without furniture: what is measured can be computed by
// hand.
struct RoomOptions {
  // Along the room's x and y axes; its origin is in the middle.
  double width_m = 8;
  double depth_m = 6;
  // Where the laser stands, inside, and which way it looks (from x towards y).
  double laser_x_m = 0;
  double laser_y_m = 0;
  double laser_yaw_rad = 0;
  // Standard deviation of each range, and how often a beam gets no echo.
  double noise_m = 0;
  double dropout = 0;
  uint64_t seed = 1;

  absl::Status Validate() const;
};
// "8x6" into width and depth. INVALID_ARGUMENT says what is wrong.
absl::StatusOr<RoomOptions> ParseRoom(absl::string_view text);

// How far the walls are from the laser in the direction `bearing_rad`
// (counter-clockwise from straight ahead).
double DistanceToWall_m(const RoomOptions& room, double bearing_rad);

class RoomLaserSource final : public LaserSource {
 public:
  // `room` must be valid.
  explicit RoomLaserSource(const RoomOptions& room) : room_(room) {}
  core::LaserScan ScanAt(base::MonotonicTime start,
                         const core::RangeSensorInfo& info) override;

 private:
  RoomOptions room_;
};

}  // namespace treeline::emulators

#endif  // SIMULATION_EMULATORS_LASER_SOURCE_H_
