#include "nav_agent/map_bundle/upright.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "common/base/random.h"

namespace treeline::map_bundle {
namespace {

constexpr int kTrials = 400;
constexpr double kMaxTilt_rad = 0.6;
constexpr int kRefinements = 3;
// Where a wall crosses the plane, most points of a cell are above or below it.
constexpr double kCell_m = 0.1;
constexpr double kBand_m = 0.15;
constexpr double kOnPlane_m = 0.03;
// Smaller planes say nothing.
constexpr double kMinShare = 0.05;
// Below a floor there are reflections at most.
constexpr double kBelowFloor = 0.02;
constexpr double kFarBelow_m = 0.1;

constexpr geometry::Vec3 kUp{0, 0, 1};

// The shortest rotation that turns a unit vector upright.
geometry::Rotation3 Upright(geometry::Vec3 up) {
  const geometry::Vec3 axis = geometry::Cross(up, kUp);
  const double sine = geometry::Norm(axis);
  const double angle_rad = std::atan2(sine, geometry::Dot(up, kUp));
  if (sine < 1e-12) {
    return angle_rad < 1
               ? geometry::Rotation3{}
               : geometry::Rotation3::FromAxisAngle({angle_rad, 0, 0});
  }
  return geometry::Rotation3::FromAxisAngle((angle_rad / sine) * axis);
}

struct Plane {
  geometry::Vec3 normal;
  double height = 0;  // Dot(normal, point) of its points
  size_t points = 0;
};

size_t CountOn(std::span<const geometry::Vec3> points, geometry::Vec3 normal,
               double height) {
  return static_cast<size_t>(
      std::count_if(points.begin(), points.end(), [&](geometry::Vec3 point) {
        return std::abs(geometry::Dot(normal, point) - height) < kOnPlane_m;
      }));
}

Plane LargestPlane(std::span<const geometry::Vec3> points, geometry::Vec3 up,
                   uint64_t seed) {
  Plane best;
  const auto count = static_cast<uint32_t>(points.size());
  for (uint64_t trial = 0; trial < kTrials; ++trial) {
    base::Random random(seed, trial);
    const geometry::Vec3 a = points[random.NextBelow(count)];
    const geometry::Vec3 b = points[random.NextBelow(count)];
    const geometry::Vec3 c = points[random.NextBelow(count)];
    geometry::Vec3 normal = geometry::Cross(b - a, c - a);
    if (geometry::SquaredNorm(normal) < 1e-6) continue;
    normal = geometry::Normalized(normal);
    if (geometry::Dot(normal, up) < 0) normal = -normal;
    if (geometry::Dot(normal, up) < std::cos(kMaxTilt_rad)) continue;
    const size_t on = CountOn(points, normal, geometry::Dot(normal, a));
    if (on > best.points) best = {normal, geometry::Dot(normal, a), on};
  }
  return best;
}

// Of a grid in the plane.
using Cell = std::pair<int64_t, int64_t>;

// The points on `plane` and not on a wall that crosses it, in a frame in which
// the plane is level.
std::vector<geometry::Vec3> PointsOf(
    std::span<const geometry::Vec3> points, const Plane& plane,
    const geometry::Rotation3& level_from_map) {
  std::map<Cell, std::vector<geometry::Vec3>> cells;
  for (const geometry::Vec3 point_in_map : points) {
    const geometry::Vec3 point = level_from_map * point_in_map;
    if (std::abs(point.z - plane.height) > kBand_m) continue;
    const Cell cell = {std::llround(point.x / kCell_m),
                       std::llround(point.y / kCell_m)};
    cells[cell].push_back(point);
  }
  const auto is_on = [&plane](geometry::Vec3 point) {
    return std::abs(point.z - plane.height) < kOnPlane_m;
  };
  std::vector<geometry::Vec3> on;
  for (const auto& [cell, inside] : cells) {
    const auto count = std::count_if(inside.begin(), inside.end(), is_on);
    if (2 * count < static_cast<std::ptrdiff_t>(inside.size())) continue;
    std::copy_if(inside.begin(), inside.end(), std::back_inserter(on), is_on);
  }
  return on;
}

// The least-squares plane z = p x + q y + r of the points on `plane`, which is
// nearly level in the frame of `level_from_map`.
Plane Refined(std::span<const geometry::Vec3> points, const Plane& plane) {
  const geometry::Rotation3 level_from_map = Upright(plane.normal);
  const std::vector<geometry::Vec3> on =
      PointsOf(points, plane, level_from_map);
  if (on.size() < 3) return plane;
  geometry::Vec3 mean;
  for (const geometry::Vec3 point : on) mean = mean + point;
  mean = mean / static_cast<double>(on.size());
  double xx = 0;
  double xy = 0;
  double yy = 0;
  double xz = 0;
  double yz = 0;
  for (const geometry::Vec3 point : on) {
    const geometry::Vec3 d = point - mean;
    xx += d.x * d.x;
    xy += d.x * d.y;
    yy += d.y * d.y;
    xz += d.x * d.z;
    yz += d.y * d.z;
  }
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 1e-9 * xx * yy)) return plane;
  const double p = (xz * yy - yz * xy) / determinant;
  const double q = (yz * xx - xz * xy) / determinant;
  const geometry::Vec3 normal = level_from_map.Inverse() *
                                geometry::Normalized(geometry::Vec3{-p, -q, 1});
  const double height = geometry::Dot(normal, level_from_map.Inverse() * mean);
  return {normal, height, CountOn(points, normal, height)};
}

}  // namespace

UprightMap FindUpright(std::span<const geometry::Vec3> points_in_map,
                       geometry::Vec3 up_guess_in_map, uint64_t seed) {
  const double length = geometry::Norm(up_guess_in_map);
  geometry::Vec3 up = length > 1e-9 ? up_guess_in_map / length : kUp;
  UprightMap upright;
  if (points_in_map.size() < 3) {
    upright.level_from_map.rotation = Upright(up);
    return upright;
  }
  Plane plane = LargestPlane(points_in_map, up, seed);
  const auto all = static_cast<double>(points_in_map.size());
  upright.has_surface = static_cast<double>(plane.points) >= kMinShare * all;
  if (upright.has_surface) {
    for (int round = 0; round < kRefinements; ++round) {
      plane = Refined(points_in_map, plane);
    }
    up = plane.normal;
    upright.share = static_cast<double>(plane.points) / all;
  }
  std::vector<double> heights;
  heights.reserve(points_in_map.size());
  for (const geometry::Vec3 point : points_in_map)
    heights.push_back(geometry::Dot(up, point));
  const auto low =
      heights.begin() + static_cast<std::ptrdiff_t>(kBelowFloor * all);
  std::nth_element(heights.begin(), low, heights.end());
  const bool is_floor =
      upright.has_surface && *low > plane.height - kFarBelow_m;
  upright.level_from_map = {Upright(up),
                            {0, 0, -(is_floor ? plane.height : *low)}};
  return upright;
}

}  // namespace treeline::map_bundle
