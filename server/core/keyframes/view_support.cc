#include "server/core/keyframes/view_support.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

using geometry::Vec3;

constexpr size_t kAzimuths = 2 * kSupportRows;
constexpr double kStep_rad =
    std::numbers::pi / static_cast<double>(kSupportRows);

Vec3 ToVec3(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

// Of a vector of this length that is not zero.
size_t DirectionOf(float x, float y, float z, float length) {
  constexpr auto kPi = std::numbers::pi_v<float>;
  constexpr auto kPerRadian = static_cast<float>(1 / kStep_rad);
  const auto azimuth =
      static_cast<size_t>((std::atan2(y, x) + kPi) * kPerRadian);
  const auto row = static_cast<size_t>(
      std::acos(std::clamp(z / length, -1.0F, 1.0F)) * kPerRadian);
  return std::min(row, kSupportRows - 1) * kAzimuths + azimuth % kAzimuths;
}

}  // namespace

std::vector<KeyframePoint> SomePoints(const KeyframeMap& map, size_t keyframe,
                                      size_t count) {
  const std::span<const KeyframePoint> points = map.points(keyframe);
  count = std::min(count, points.size());
  std::vector<KeyframePoint> some;
  some.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    some.push_back(points[i * points.size() / count]);
  }
  return some;
}

ViewSupport::ViewSupport(const KeyframeMap& map,
                         const geometry::Rotation3& plan_from_world) {
  const geometry::Mat3 matrix = plan_from_world.Matrix();
  for (size_t k = 0; k < map.size(); ++k) {
    const Vec3 camera = map.world_from_camera(k).translation;
    for (const KeyframePoint& point : SomePoints(map, k, kSupportPoints)) {
      const Vec3 position = ToVec3(point.position_in_world);
      const double distance = geometry::Norm(position - camera);
      if (!(distance > kMinPointDepth_m)) continue;
      const auto& [nx, ny, nz] = point.normal_in_world;
      const Vec3 at = matrix * position;
      const Vec3 from = matrix * ((position - camera) / distance);
      const Vec3 normal =
          matrix * (Vec3{static_cast<double>(nx), static_cast<double>(ny),
                         static_cast<double>(nz)} /
                    127.0);
      const auto single = [](double v) { return static_cast<float>(v); };
      points_.push_back({.x = single(at.x),
                         .y = single(at.y),
                         .z = single(at.z),
                         .nx = single(normal.x),
                         .ny = single(normal.y),
                         .nz = single(normal.z),
                         .from_x = single(from.x),
                         .from_y = single(from.y),
                         .from_z = single(from.z),
                         .log_distance = single(std::log(distance))});
    }
  }
}

ViewSupport::Panorama ViewSupport::PanoramaAt(Vec3 place_in_plan) const {
  constexpr size_t kDirections = kSupportRows * kAzimuths;
  struct Seen {
    size_t direction;
    float distance;
    float weight;
  };
  const auto cx = static_cast<float>(place_in_plan.x);
  const auto cy = static_cast<float>(place_in_plan.y);
  const auto cz = static_cast<float>(place_in_plan.z);
  const float per_turn = 1 / (kSupportAngle_rad * kSupportAngle_rad);
  const float log_ratio = std::log(static_cast<float>(kSupportRatio));
  const float per_ratio = 0.5F / (log_ratio * log_ratio);
  std::vector<float> nearest(kDirections,
                             std::numeric_limits<float>::infinity());
  std::vector<Seen> supporting;
  for (const Point& point : points_) {
    const float x = point.x - cx;
    const float y = point.y - cy;
    const float z = point.z - cz;
    const float distance = std::sqrt(x * x + y * y + z * z);
    if (!(distance > static_cast<float>(kMinPointDepth_m))) continue;
    const size_t direction = DirectionOf(x, y, z, distance);
    nearest[direction] = std::min(nearest[direction], distance);
    const bool has_normal = point.nx != 0 || point.ny != 0 || point.nz != 0;
    const float facing = -(x * point.nx + y * point.ny + z * point.nz);
    if (has_normal && facing < kMinFacing * distance) continue;
    const float turn =
        1 - (x * point.from_x + y * point.from_y + z * point.from_z) / distance;
    const float ratio = std::log(distance) - point.log_distance;
    supporting.push_back(
        {direction, distance,
         std::exp(-turn * per_turn - ratio * ratio * per_ratio)});
  }
  Panorama panorama(kDirections, 0);
  for (const Seen& seen : supporting) {
    const float hidden_from =
        (1 + kHiddenBehind) * nearest[seen.direction] + kHiddenBehind_m;
    if (seen.distance < hidden_from) panorama[seen.direction] += seen.weight;
  }
  for (float& support : panorama) {
    support = std::min(1.0F, support / kFullSupport);
  }
  return panorama;
}

std::vector<ViewSupport::SeenDirection> DirectionsInPicture(
    const camera::Camera& camera, const geometry::Rotation3& plan_from_camera) {
  const geometry::Mat3 camera_from_plan = plan_from_camera.Inverse().Matrix();
  std::vector<ViewSupport::SeenDirection> seen;
  double total = 0;
  for (size_t row = 0; row < kSupportRows; ++row) {
    const double from_up = (static_cast<double>(row) + 0.5) * kStep_rad;
    for (size_t column = 0; column < kAzimuths; ++column) {
      const double azimuth =
          (static_cast<double>(column) + 0.5) * kStep_rad - std::numbers::pi;
      const Vec3 ray =
          camera_from_plan * Vec3{std::sin(from_up) * std::cos(azimuth),
                                  std::sin(from_up) * std::sin(azimuth),
                                  std::cos(from_up)};
      if (!(ray.z > 0)) continue;
      const double u = camera.fx() * ray.x / ray.z + camera.cx();
      const double v = camera.fy() * ray.y / ray.z + camera.cy();
      if (u < 0 || v < 0 || u > camera.width() || v > camera.height()) continue;
      seen.push_back({row * kAzimuths + column, std::sin(from_up)});
      total += std::sin(from_up);
    }
  }
  for (ViewSupport::SeenDirection& direction : seen) direction.share /= total;
  return seen;
}

double SupportOf(const ViewSupport::Panorama& panorama,
                 const std::vector<ViewSupport::SeenDirection>& picture) {
  double support = 0;
  for (const auto& [direction, share] : picture) {
    support += share * panorama[direction];
  }
  return support;
}

}  // namespace treeline::keyframes
