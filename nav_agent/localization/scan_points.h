// Where the beams of a scan end, as particles are judged by them.
#ifndef NAV_AGENT_LOCALIZATION_SCAN_POINTS_H_
#define NAV_AGENT_LOCALIZATION_SCAN_POINTS_H_

#include <vector>

#include "absl/status/statusor.h"
#include "common/geometry/rigid2.h"
#include "common/geometry/rigid3.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::localization {

// End points in the base frame (m), projected onto its plane, in the order of
// the beams. One array a coordinate, as SIMD wants them. Heights above the
// ground below the robot are there if its tilt was known; then x and y are of
// the frame that is level, not of one that leans with the robot.
struct ScanPoints {
  std::vector<float> x_m = {};
  std::vector<float> y_m = {};
  std::vector<float> z_m = {};

  size_t size() const { return x_m.size(); }
  bool has_heights() const { return z_m.size() == x_m.size(); }
  // Appends point i of another.
  void Add(const ScanPoints& from, size_t i);
};

// Of at most max_points beams, evenly spread over what is seen, by its width:
// of those that end 0.1 m apart. No return, or one out of the laser's range, is
// no end. INVALID_ARGUMENT: not as many beams as `info` says.
absl::StatusOr<ScanPoints> PointsOf(const core::LaserScan& scan,
                                    const core::RangeSensorInfo& info,
                                    const geometry::Rigid2& base_from_laser,
                                    int max_points);

// The same in space: of a robot that leans. `level_from_base` has no yaw (see
// SlopeOdometry::LevelFromBase).
absl::StatusOr<ScanPoints> PointsInSpace(
    const core::LaserScan& scan, const core::RangeSensorInfo& info,
    const geometry::Rigid3& base_from_laser,
    const geometry::Rotation3& level_from_base, int max_points);

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_SCAN_POINTS_H_
