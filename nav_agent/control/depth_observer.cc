#include "nav_agent/control/depth_observer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "nav_agent/control/obstacle_parameters.h"

namespace treeline::control {

absl::Status DepthObserver::Check(const core::RgbdFrame& frame) {
  if (!frame.frame.depth.has_value() || !frame.frame.calibration.has_value()) {
    return absl::InvalidArgumentError(
        "a frame has no depth, or no calibration");
  }
  const image::DepthImage& depth = *frame.frame.depth;
  const size_t pixels =
      static_cast<size_t>(depth.width) * static_cast<size_t>(depth.height);
  if (depth.width < 1 || depth.height < 1 || depth.values.size() != pixels) {
    return absl::InvalidArgumentError("a depth picture has a wrong size");
  }
  return absl::OkStatus();
}

std::vector<DepthObserver::DepthPoint> DepthObserver::PointsOf(
    const ControlPose& pose, const core::RgbdFrame& frame) const {
  const image::DepthImage& depth = *frame.frame.depth;
  const camera::RgbdCalibration& calibration = *frame.frame.calibration;
  const geometry::Rigid3 map_from_depth =
      MapFromBase3(pose) *
      camera::PoseOfSensor(base_from_camera_, calibration.pose_sensor,
                           camera::RgbdSensor::kDepth, calibration);
  std::vector<DepthPoint> points;
  const int stride_px = std::max(1, depth.width / kDepthColumns);
  for (int y = 0; y < depth.height; y += stride_px) {
    for (int x = 0; x < depth.width; x += stride_px) {
      const uint16_t value = depth.values[static_cast<size_t>(y) *
                                              static_cast<size_t>(depth.width) +
                                          static_cast<size_t>(x)];
      if (!image::IsMeasured(value)) continue;
      const double z_m = value * depth.unit_m * calibration.depth_scale;
      if (z_m > kDepthRange_m) continue;
      const std::optional<camera::Pixel> ray = calibration.depth.Unproject(
          {static_cast<double>(x), static_cast<double>(y)});
      if (!ray.has_value()) continue;
      points.push_back(
          {.in_map =
               map_from_depth * geometry::Vec3{ray->x * z_m, ray->y * z_m, z_m},
           .z_m = z_m});
    }
  }
  return points;
}

void DepthObserver::Add(const ControlPose& pose, const core::RgbdFrame& frame,
                        const CostmapWindow& window, const GroundLayer& ground,
                        int64_t now_ms, ObstacleLayer& obstacles) {
  last_frame_ = frame.stamp;
  const geometry::Vec2 at = pose.pose.map_from_base.translation;
  points_.clear();
  obstacles.BeginLook();
  std::vector<size_t> passed;
  for (const DepthPoint& point : PointsOf(pose, frame)) {
    const geometry::Vec3& end = point.in_map;
    const core::CellIndex cell = window.CellOf({end.x, end.y});
    if (!window.IsInside(cell)) continue;
    const size_t index = window.IndexOf(cell.x, cell.y);
    if (!ground.IsHeightOfObstacle(window, cell, end.z, point.z_m,
                                   robot_height_m_)) {
      // What shows its ground is free.
      if (ground.IsGround(index) &&
          end.z < ground.Height_m(index) + kGroundTolerance_m) {
        passed.push_back(index);
      }
      continue;
    }
    if (!ground.IsNearMap(index)) obstacles.Hit(index);
    if (std::hypot(end.x - at.x, end.y - at.y) < kPointReach_m) {
      points_.push_back(
          {.in_map = {end.x, end.y}, .is_new = obstacles.IsNew(index, ground)});
    }
  }
  for (const size_t i : passed) obstacles.ClearByDepth(i, now_ms);
  obstacles.MarkDepthHits(now_ms);
  for (ObservedPoint& point : points_) {
    point.is_moving =
        obstacles.IsMoving(window, ground, window.CellOf(point.in_map), now_ms);
  }
}

}  // namespace treeline::control
