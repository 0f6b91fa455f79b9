// Depth images of simple things, for tests and benchmarks.
#ifndef NAV_AGENT_FUSION_TESTING_VIEWS_H_
#define NAV_AGENT_FUSION_TESTING_VIEWS_H_

#include <algorithm>
#include <functional>

#include "common/base/random.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "common/image/image.h"

namespace treeline::fusion {

// An image in millimetres; depth_m gives the depth (m) along the ray (x, y, 1)
// in the camera's frame, 0 for none.
inline image::DepthImage MakeDepth(
    const camera::Camera& camera,
    const std::function<double(double, double)>& depth_m) {
  image::DepthImage image{
      .width = camera.width(), .height = camera.height(), .values = {}};
  for (int y = 0; y < camera.height(); ++y) {
    for (int x = 0; x < camera.width(); ++x) {
      const camera::Pixel ray{(x - camera.cx()) / camera.fx(),
                              (y - camera.cy()) / camera.fy()};
      image.values.push_back(
          static_cast<uint16_t>(1000 * depth_m(ray.x, ray.y) + 0.5));
    }
  }
  return image;
}

// Inside of a box room of 6 x 5 x 2.6 m whose floor is at z = 0 and whose
// middle is at the map's origin, with the noise of a structured-light sensor.
inline image::DepthImage MakeRoomDepth(const camera::Camera& camera,
                                       const geometry::Rigid3& map_from_camera,
                                       uint64_t seed) {
  constexpr double kHalfX_m = 3;
  constexpr double kHalfY_m = 2.5;
  constexpr double kHeight_m = 2.6;
  base::Random random(seed, 0);
  const geometry::Vec3 from = map_from_camera.translation;
  return MakeDepth(camera, [&](double x, double y) {
    const geometry::Vec3 ray =
        map_from_camera.rotation * geometry::Vec3{x, y, 1};
    const auto reach = [](double at, double step, double low, double high) {
      return step > 0 ? (high - at) / step : (low - at) / step;
    };
    double depth_m = 65;
    if (ray.x != 0) {
      depth_m = std::min(depth_m, reach(from.x, ray.x, -kHalfX_m, kHalfX_m));
    }
    if (ray.y != 0) {
      depth_m = std::min(depth_m, reach(from.y, ray.y, -kHalfY_m, kHalfY_m));
    }
    if (ray.z != 0) {
      depth_m = std::min(depth_m, reach(from.z, ray.z, 0, kHeight_m));
    }
    return std::max(0.0, depth_m + random.NextGaussian() *
                                       (0.0012 + 0.0019 * (depth_m - 0.4) *
                                                     (depth_m - 0.4)));
  });
}

// A camera at `position` that looks level along the direction yaw_rad.
inline geometry::Rigid3 LevelCamera(geometry::Vec3 position, double yaw_rad) {
  // Camera axes in the map at yaw 0: x is -y, y is -z, z is x.
  const geometry::Rotation3 ahead = geometry::Rotation3::FromMatrix(
      geometry::Mat3{{0, 0, 1, -1, 0, 0, 0, -1, 0}});
  return {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad}) * ahead,
      .translation = position};
}

}  // namespace treeline::fusion

#endif  // NAV_AGENT_FUSION_TESTING_VIEWS_H_
