#include "server/core/keyframes/measured_surfaces.h"

#include <cmath>
#include <cstddef>

#include "server/core/features/rgbd_samples.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {

MeasuredSurfaces::MeasuredSurfaces(const image::DepthImage& depth,
                                   const camera::RgbdCalibration& calibration)
    : depth_(depth),
      calibration_(calibration),
      depth_from_color_(calibration.color_from_depth.Inverse()) {}

std::optional<MeasuredPoint> MeasuredSurfaces::At(geometry::Vec3 point) const {
  const camera::Camera& camera = calibration_.depth;
  const geometry::Vec3 q = depth_from_color_ * point;
  if (!(q.z > kMinPointDepth_m)) return std::nullopt;
  const camera::Pixel pixel = camera.Project(q);
  if (!(pixel.x > 0 && pixel.y > 0 && pixel.x < camera.width() - 1 &&
        pixel.y < camera.height() - 1)) {
    return std::nullopt;
  }
  const int x = static_cast<int>(pixel.x + 0.5);
  const int y = static_cast<int>(pixel.y + 0.5);
  const uint16_t value =
      depth_.values[static_cast<size_t>(y) * static_cast<size_t>(depth_.width) +
                    static_cast<size_t>(x)];
  if (!image::IsMeasured(value)) return std::nullopt;
  const double z = calibration_.depth_scale * depth_.unit_m * value;
  // The ray through the pixel's centre, from that through the point's image.
  const geometry::Vec3 ray{q.x / q.z + (x - pixel.x) / camera.fx(),
                           q.y / q.z + (y - pixel.y) / camera.fy(), 1};
  return MeasuredPoint{calibration_.color_from_depth * (z * ray),
                       features::DepthSigma_m(z)};
}

Surface MeasuredSurfaces::SurfaceAt(geometry::Vec3 point,
                                    geometry::Vec3 normal) const {
  const std::optional<MeasuredPoint> measured = At(point);
  if (!measured) return Surface::kUnknown;
  const double tolerance_m = 3 * measured->sigma_m;
  if (point.z - measured->in_color.z > kOccluderDistance_m + tolerance_m) {
    return Surface::kHidden;
  }
  if (normal == geometry::Vec3{}) return Surface::kUnknown;
  const double distance_m = geometry::Dot(normal, point - measured->in_color);
  return std::abs(distance_m) <= 0.02 + tolerance_m ? Surface::kLying
                                                    : Surface::kElsewhere;
}

}  // namespace treeline::keyframes
