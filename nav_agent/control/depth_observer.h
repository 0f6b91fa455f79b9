// What the depth camera shows around the robot.
#ifndef NAV_AGENT_CONTROL_DEPTH_OBSERVER_H_
#define NAV_AGENT_CONTROL_DEPTH_OBSERVER_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "common/base/clock.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/costmap_window.h"
#include "nav_agent/control/ground_layer.h"
#include "nav_agent/control/observed_point.h"
#include "nav_agent/control/obstacle_layer.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

// Takes depth pictures into an ObstacleLayer: points at the height of an
// obstacle mark, points on the ground of their cell clear it. Not thread-safe.
class DepthObserver {
 public:
  DepthObserver(const geometry::Rigid3& base_from_camera, double robot_height_m)
      : base_from_camera_(base_from_camera), robot_height_m_(robot_height_m) {}

  // INVALID_ARGUMENT: there is no depth, or of a wrong size, or no calibration.
  static absl::Status Check(const core::RgbdFrame& frame);
  // A frame that was checked, from a finite pose. Cells that it hit are in
  // obstacles.hits() afterwards.
  void Add(const ControlPose& pose, const core::RgbdFrame& frame,
           const CostmapWindow& window, const GroundLayer& ground,
           int64_t now_ms, ObstacleLayer& obstacles);
  void ForgetPoints() { points_.clear(); }

  // The newest frame's points on obstacles, the map's included, near the robot.
  std::span<const ObservedPoint> points() const { return points_; }
  std::optional<base::MonotonicTime> last_frame() const { return last_frame_; }

 private:
  // A pixel in the map, and how far before the camera it is.
  struct DepthPoint {
    geometry::Vec3 in_map;
    double z_m = 0;
  };
  std::vector<DepthPoint> PointsOf(const ControlPose& pose,
                                   const core::RgbdFrame& frame) const;

  geometry::Rigid3 base_from_camera_;
  double robot_height_m_;
  std::optional<base::MonotonicTime> last_frame_;
  std::vector<ObservedPoint> points_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_DEPTH_OBSERVER_H_
