// A room full of corners for tests, seen without a renderer: six walls with a
// pattern, and the depth that goes with them.
#ifndef NAV_AGENT_RGBD_SLAM_TESTING_ROOM_H_
#define NAV_AGENT_RGBD_SLAM_TESTING_ROOM_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "common/base/random.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"

namespace treeline::rgbd_slam {

// Depth is registered to colour.
inline camera::RgbdCalibration TestingCalibration() {
  camera::RgbdCalibration calibration;
  calibration.color =
      camera::Camera::Parse("PINHOLE,260,260,159.5,119.5", 320, 240).value();
  calibration.depth = calibration.color;
  return calibration;
}

// Brightness 40..215 of a wall at (u, v) metres: tiles of 31, 13 and 7 cm.
inline double TestingPattern(int wall, double u, double v) {
  constexpr std::array<double, 3> kTiles_m = {0.31, 0.13, 0.07};
  double sum = 0;
  for (size_t i = 0; i < kTiles_m.size(); ++i) {
    const auto column = static_cast<int64_t>(std::floor(u / kTiles_m[i]));
    const auto row = static_cast<int64_t>(std::floor(v / kTiles_m[i]));
    const uint64_t key =
        base::MixBits(static_cast<uint64_t>(column + 100000) << 32 |
                      static_cast<uint64_t>(row + 100000)) +
        static_cast<uint64_t>(wall) * 3 + i;
    sum += static_cast<double>(base::MixBits(key) >> 56) / 255;
  }
  return 40 + 175 * sum / 3;
}

struct WallSample {
  double brightness = 0;
  // In lengths of the ray.
  double depth_m = 0;
};

// What a ray meets in the box |x| < 2.5, |y| < 2, |z| < 1.25 (m).
inline WallSample LookAtWall(geometry::Vec3 from, geometry::Vec3 ray) {
  constexpr std::array<double, 3> kHalf_m = {2.5, 2, 1.25};
  double depth_m = std::numeric_limits<double>::infinity();
  int axis = 0;
  for (int a = 0; a < 3; ++a) {
    const double half_m = kHalf_m[static_cast<size_t>(a)];
    const double way_m = ((ray[a] > 0 ? half_m : -half_m) - from[a]) / ray[a];
    if (way_m < depth_m) {
      depth_m = way_m;
      axis = a;
    }
  }
  const geometry::Vec3 hit = from + depth_m * ray;
  return {TestingPattern(2 * axis + (ray[axis] > 0 ? 1 : 0),
                         hit[(axis + 1) % 3], hit[(axis + 2) % 3]),
          depth_m};
}

// What the colour camera of `calibration` sees from inside of that box. Depth
// in millimetres, with the noise of a Kinect (Nguyen, Izadi, Lovell 2012) drawn
// from `noise_seed`.
inline image::Frame SeeTestingRoom(const camera::RgbdCalibration& calibration,
                                   const geometry::Rigid3& world_from_camera,
                                   uint64_t noise_seed) {
  const camera::Camera& camera = calibration.color;
  const auto pixels = static_cast<size_t>(camera.width()) *
                      static_cast<size_t>(camera.height());
  image::Frame frame;
  frame.color = {camera.width(), camera.height(),
                 std::vector<uint8_t>(3 * pixels)};
  frame.depth = image::DepthImage{camera.width(), camera.height(),
                                  std::vector<uint16_t>(pixels), 0.001};
  const geometry::Mat3 rotation = world_from_camera.rotation.Matrix();
  const geometry::Vec3 from = world_from_camera.translation;
  base::Random random(noise_seed, 0);
  const auto width = static_cast<size_t>(camera.width());
  for (size_t i = 0; i < pixels; ++i) {
    const auto x = static_cast<double>(i % width);
    const auto y = static_cast<double>(i / width);
    const auto look = [&](double dx, double dy) {
      return LookAtWall(
          from,
          rotation * geometry::Vec3{(x + dx - camera.cx()) / camera.fx(),
                                    (y + dy - camera.cy()) / camera.fy(), 1});
    };
    // The mean of four rays, so that edges are smooth.
    double sum = 0;
    for (const double dx : {-0.25, 0.25}) {
      for (const double dy : {-0.25, 0.25}) sum += look(dx, dy).brightness;
    }
    const double value = sum / 4 + 1.5 * random.NextGaussian();
    for (size_t c = 0; c < 3; ++c) {
      frame.color.rgb[3 * i + c] = static_cast<uint8_t>(std::lround(value));
    }
    const double depth_m = look(0, 0).depth_m;
    const double sigma_m = 0.0012 + 0.0019 * (depth_m - 0.4) * (depth_m - 0.4);
    const double measured_m = depth_m + sigma_m * random.NextGaussian();
    frame.depth->values[i] =
        static_cast<uint16_t>(std::lround(1000 * measured_m));
  }
  return frame;
}

// Level, `yaw_rad` to the left of the world's x axis.
inline geometry::Rigid3 TestingPose(double x_m, double y_m, double yaw_rad) {
  // The camera's axes in the world: x right, y down, z forward.
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  const geometry::Mat3 axes{{s, 0, c, -c, 0, s, 0, -1, 0}};
  return {.rotation = geometry::Rotation3::FromMatrix(axes),
          .translation = {x_m, y_m, 0.05}};
}

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_TESTING_ROOM_H_
