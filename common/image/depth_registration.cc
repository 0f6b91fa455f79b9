#include "common/image/depth_registration.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeline::image {
namespace {

constexpr double kMaxDepthJump = 0.05;
constexpr int kDepthRadius_px = 2;

}  // namespace

DepthRegistrar::DepthRegistrar(const camera::RgbdCalibration& calibration)
    : calibration_(calibration) {
  const camera::Camera& depth = calibration.depth;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      const camera::Pixel pixel{static_cast<double>(x), static_cast<double>(y)};
      rays_.push_back(
          depth.Unproject(pixel).value_or(camera::Pixel{kNan, kNan}));
    }
  }
}

std::vector<geometry::Vec3> DepthRegistrar::PointsInColor(
    const DepthImage& depth) const {
  const camera::Camera& color = calibration_.color;
  std::vector<geometry::Vec3> points(static_cast<size_t>(color.width()) *
                                     static_cast<size_t>(color.height()));
  const size_t count = std::min(rays_.size(), depth.values.size());
  for (size_t i = 0; i < count; ++i) {
    if (!IsMeasured(depth.values[i]) || std::isnan(rays_[i].x)) continue;
    const double z = calibration_.depth_scale * depth.unit_m * depth.values[i];
    const geometry::Vec3 point =
        calibration_.color_from_depth *
        geometry::Vec3{z * rays_[i].x, z * rays_[i].y, z};
    if (point.z <= 0) continue;
    const camera::Pixel pixel = color.Project(point);
    const double x = std::round(pixel.x);
    const double y = std::round(pixel.y);
    if (!(x >= 0 && x < color.width() && y >= 0 && y < color.height())) {
      continue;
    }
    geometry::Vec3& held =
        points[static_cast<size_t>(y) * static_cast<size_t>(color.width()) +
               static_cast<size_t>(x)];
    if (held.z == 0 || point.z < held.z) held = point;
  }
  return points;
}

std::optional<geometry::Vec3> DepthRegistrar::PointAt(
    const std::vector<geometry::Vec3>& points_in_color,
    camera::Pixel pixel) const {
  const camera::Camera& color = calibration_.color;
  const int x0 = static_cast<int>(std::lround(pixel.x));
  const int y0 = static_cast<int>(std::lround(pixel.y));
  double depth_m = 0;
  double best_distance_px = std::numeric_limits<double>::infinity();
  double nearest_m = std::numeric_limits<double>::infinity();
  double max_reach_m = 0;
  for (int y = std::max(0, y0 - kDepthRadius_px);
       y <= std::min(color.height() - 1, y0 + kDepthRadius_px); ++y) {
    for (int x = std::max(0, x0 - kDepthRadius_px);
         x <= std::min(color.width() - 1, x0 + kDepthRadius_px); ++x) {
      const geometry::Vec3& point =
          points_in_color[static_cast<size_t>(y) *
                              static_cast<size_t>(color.width()) +
                          static_cast<size_t>(x)];
      if (point.z == 0) continue;
      nearest_m = std::min(nearest_m, point.z);
      max_reach_m = std::max(max_reach_m, point.z);
      const double distance_px = std::hypot(x - pixel.x, y - pixel.y);
      if (distance_px < best_distance_px) {
        best_distance_px = distance_px;
        depth_m = point.z;
      }
    }
  }
  if (max_reach_m == 0 || max_reach_m > (1 + kMaxDepthJump) * nearest_m) {
    return std::nullopt;
  }
  const std::optional<camera::Pixel> ray = color.Unproject(pixel);
  if (!ray) return std::nullopt;
  return geometry::Vec3{depth_m * ray->x, depth_m * ray->y, depth_m};
}

}  // namespace treeline::image
