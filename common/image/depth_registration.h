// Depth as the colour camera sees it.
#ifndef COMMON_IMAGE_DEPTH_REGISTRATION_H_
#define COMMON_IMAGE_DEPTH_REGISTRATION_H_

#include <optional>
#include <vector>

#include "common/camera/rgbd_calibration.h"
#include "common/image/image.h"

namespace treeline {

// Depth seen from the colour camera: for each colour pixel, row by row, the
// nearest measured point that falls on it, in the colour camera's frame (world
// units); z is 0 where there is none.
class DepthRegistration {
 public:
  explicit DepthRegistration(const RgbdCalibration& calibration);

  std::vector<Vec3> PointsInColor(const DepthImage& depth) const;

  // The point seen at `pixel`: on its ray, as far along the optical axis as
  // the nearest measured pixel within 2 px. nullopt: none, or depth jumps
  // there by more than 5 %.
  std::optional<Vec3> PointAt(const std::vector<Vec3>& points_in_color,
                              Pixel pixel) const;

 private:
  const RgbdCalibration calibration_;
  // Rays of the depth camera's pixels, (x/z, y/z); NaN where there is none.
  std::vector<Pixel> rays_;
};

}  // namespace treeline

#endif  // COMMON_IMAGE_DEPTH_REGISTRATION_H_
