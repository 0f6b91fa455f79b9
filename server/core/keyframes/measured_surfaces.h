// What a depth image says of points that should be seen in it.
#ifndef SERVER_CORE_KEYFRAMES_MEASURED_SURFACES_H_
#define SERVER_CORE_KEYFRAMES_MEASURED_SURFACES_H_

#include <cstdint>
#include <optional>

#include "common/camera/rgbd_calibration.h"
#include "common/geometry/rigid3.h"
#include "common/image/image.h"

namespace treeline::keyframes {

struct MeasuredPoint {
  geometry::Vec3 in_color;  // in the colour camera (m)
  double sigma_m = 0;       // of its distance
};

enum class Surface : uint8_t {
  kUnknown,    // nothing was measured there, or the point's normal is not known
  kLying,      // the point lies on what was measured
  kHidden,     // something was measured well before it
  kElsewhere,  // what was measured is behind it, or a little before it
};

// Points are of the colour camera (m). The image and the calibration must
// outlive it.
class MeasuredSurfaces {
 public:
  MeasuredSurfaces(const image::DepthImage& depth,
                   const camera::RgbdCalibration& calibration);

  // What was measured in the pixel that the point projects to.
  std::optional<MeasuredPoint> At(geometry::Vec3 point) const;
  // `normal` is a unit vector, or zero if it is not known.
  Surface SurfaceAt(geometry::Vec3 point, geometry::Vec3 normal) const;

 private:
  const image::DepthImage& depth_;
  const camera::RgbdCalibration& calibration_;
  geometry::Rigid3 depth_from_color_;
};

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_MEASURED_SURFACES_H_
