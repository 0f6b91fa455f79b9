#include "simulation/sensors/picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/camera/camera.h"
#include "simulation/sensors/synthetic_camera.h"

namespace treeline::sensors {
namespace {

// Where rays from above meet nothing.
constexpr uint8_t kPaper = 235;
// How high above a world its picture is taken, in its longer sides.
constexpr double kHeight = 1.6;

camera::Camera Pinhole(int width_px, int height_px, double focal_px) {
  const std::array<double, 4> values = {
      focal_px, focal_px, (width_px - 1) / 2.0, (height_px - 1) / 2.0};
  return *camera::Camera::Create(camera::CameraModel::kPinhole, width_px,
                                 height_px, values.data(), values.size());
}

ColorSensorOptions WithoutNoise(ColorSensorOptions sensor) {
  sensor.white_balance_error = 0;
  sensor.shot_noise = 0;
  sensor.read_noise = 0;
  sensor.noise_levels = 0;
  return sensor;
}

camera::Camera HandCamera(int width_px, int height_px) {
  return Pinhole(width_px, height_px, width_px * 525.0 / 640);
}

// From red over yellow, green and cyan to blue.
std::array<uint8_t, 3> RainbowAt(double t) {
  const auto hump = [t](double middle) {
    const double away = std::abs(t - middle);
    return static_cast<uint8_t>(255 * std::clamp(1.5 - 4 * away, 0.0, 1.0));
  };
  return {hump(0.15), hump(0.45), hump(0.80)};
}

}  // namespace

geometry::Rigid3 LookingFrom(geometry::Vec3 eye_m, double yaw_rad,
                             double pitch_rad) {
  const geometry::Vec3 forward = {std::cos(pitch_rad) * std::cos(yaw_rad),
                                  std::cos(pitch_rad) * std::sin(yaw_rad),
                                  std::sin(pitch_rad)};
  const geometry::Vec3 right = {std::sin(yaw_rad), -std::cos(yaw_rad), 0};
  const geometry::Vec3 down = Cross(forward, right);
  return {geometry::Rotation3::FromMatrix(
              geometry::Mat3{{right.x, down.x, forward.x, right.y, down.y,
                              forward.y, right.z, down.z, forward.z}}),
          eye_m};
}

image::ColorImage PictureFromAbove(const renderer::Renderer& opened,
                                   const renderer::WorldSnapshot& snapshot,
                                   int longer_side_px, int threads) {
  const worlds::Float3 size_m = opened.world().size_m;
  // A margin, since what is high is seen farther out.
  const double longer_m = 1.08 * std::max(size_m.x, size_m.y) + 0.5;
  const double focal_px = kHeight * longer_side_px;
  const auto pixels = [&](double length_m) {
    return std::max(static_cast<int>(std::lround(
                        (length_m + longer_m - std::max(size_m.x, size_m.y)) /
                        longer_m * longer_side_px)),
                    8);
  };
  const renderer::PixelRays rays(
      Pinhole(pixels(size_m.x), pixels(size_m.y), focal_px));
  const geometry::Rigid3 world_from_camera = {
      geometry::Rotation3::FromMatrix(
          geometry::Mat3{{1, 0, 0, 0, -1, 0, 0, 0, -1}}),
      {size_m.x / 2.0, size_m.y / 2.0, kHeight * longer_m}};
  const std::vector<worlds::Float3> radiance =
      opened.RenderRadiance(snapshot, rays, world_from_camera, threads);
  image::ColorImage image = ExposeColor(
      rays, radiance, WithoutNoise({.is_automatic = true}), 0, 0, threads);
  for (size_t i = 0; i < radiance.size(); ++i) {
    if (radiance[i] == worlds::Float3{}) {
      std::fill_n(image.rgb.begin() + static_cast<ptrdiff_t>(3 * i), 3, kPaper);
    }
  }
  return image;
}

image::ColorImage PictureOf(const renderer::Renderer& renderer,
                            const renderer::WorldSnapshot& snapshot,
                            const geometry::Rigid3& world_from_camera,
                            int width_px, int height_px, int threads) {
  const renderer::PixelRays rays(HandCamera(width_px, height_px));
  ColorSensorOptions sensor = ColorSensorFor(renderer.world().lighting);
  sensor.is_automatic = true;
  return ExposeColor(
      rays, renderer.RenderRadiance(snapshot, rays, world_from_camera, threads),
      WithoutNoise(sensor), 0, 0, threads);
}

image::ColorImage PictureOfDepth(const renderer::Renderer& renderer,
                                 const renderer::WorldSnapshot& snapshot,
                                 const geometry::Rigid3& world_from_camera,
                                 int width_px, int height_px, int threads) {
  const renderer::PixelRays rays(HandCamera(width_px, height_px));
  const DepthSensorOptions options;
  const image::DepthImage depth = MeasureDepth(
      rays, renderer.RenderDepth(snapshot, rays, world_from_camera, threads),
      options, 0, 0, threads);
  image::ColorImage image{.width = width_px, .height = height_px, .rgb = {}};
  image.rgb.reserve(3 * depth.values.size());
  for (const uint16_t value : depth.values) {
    std::array<uint8_t, 3> color = {0, 0, 0};
    if (image::IsMeasured(value)) {
      color = RainbowAt((depth.unit_m * value - options.min_range_m) /
                        (options.max_range_m - options.min_range_m));
    }
    image.rgb.insert(image.rgb.end(), color.begin(), color.end());
  }
  return image;
}

}  // namespace treeline::sensors
