// How a depth camera sits beside a colour camera.
#ifndef COMMON_CAMERA_RGBD_CALIBRATION_H_
#define COMMON_CAMERA_RGBD_CALIBRATION_H_

#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"

namespace treeline::camera {

// Which camera of an RGB-D pair a pose is of.
enum class RgbdSensor { kColor, kDepth };

// The calibration of an RGB-D pair.
//
// A depth pixel u with a measured depth d (m, along the optical axis) is the
// point  color_from_depth * (depth_scale * d * [depth.Unproject(u), 1])
// in the colour camera's frame. Depth that is registered to colour has
// depth == color and color_from_depth == identity.
struct RgbdCalibration {
  Camera color;
  Camera depth;
  geometry::Rigid3 color_from_depth;
  // World units per measured metre, in [0.5, 2]; see `treeline calibrate`.
  double depth_scale = 1;
  // Whose pose `world_from_camera` means for data with this calibration.
  RgbdSensor pose_sensor = RgbdSensor::kColor;

  bool operator==(const RgbdCalibration&) const = default;
};

// The pose of `wanted` given the pose of `given` at the same moment; both are
// sensors of `calibration`.
inline geometry::Rigid3 PoseOfSensor(const geometry::Rigid3& world_from_given,
                                     RgbdSensor given, RgbdSensor wanted,
                                     const RgbdCalibration& calibration) {
  if (given == wanted) return world_from_given;
  return wanted == RgbdSensor::kDepth
             ? world_from_given * calibration.color_from_depth
             : world_from_given * calibration.color_from_depth.Inverse();
}

}  // namespace treeline::camera

#endif  // COMMON_CAMERA_RGBD_CALIBRATION_H_
