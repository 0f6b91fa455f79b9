// Depth as the colour camera sees it.
#ifndef COMMON_IMAGE_DEPTH_REGISTRATION_H_
#define COMMON_IMAGE_DEPTH_REGISTRATION_H_

#include <optional>
#include <vector>

#include "common/camera/rgbd_calibration.h"
#include "common/image/image.h"

namespace treeline::image {

// Depth seen from the colour camera: for each colour pixel, row by row, the
// nearest measured point that falls on it, in the colour camera's frame (world
// units); z is 0 where there is none.
class DepthRegistrar {
 public:
  explicit DepthRegistrar(const camera::RgbdCalibration& calibration);

  std::vector<geometry::Vec3> PointsInColor(const DepthImage& depth) const;

  // The point seen at `pixel`: on its ray, as far along the optical axis as
  // the nearest measured pixel within 2 px. nullopt: none, or depth jumps
  // there by more than 5 %.
  std::optional<geometry::Vec3> PointAt(
      const std::vector<geometry::Vec3>& points_in_color,
      camera::Pixel pixel) const;

 private:
  const camera::RgbdCalibration calibration_;
  // Rays of the depth camera's pixels, (x/z, y/z); NaN where there is none.
  std::vector<camera::Pixel> rays_;
};

}  // namespace treeline::image

#endif  // COMMON_IMAGE_DEPTH_REGISTRATION_H_
