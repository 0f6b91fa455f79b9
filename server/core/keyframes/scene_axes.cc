#include "server/core/keyframes/scene_axes.h"

#include <cmath>
#include <cstddef>

#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

using geometry::Vec3;

// Zero where it is not known.
Vec3 NormalOf(const KeyframePoint& point) {
  const auto& [x, y, z] = point.normal_in_world;
  const Vec3 normal{static_cast<double>(x), static_cast<double>(y),
                    static_cast<double>(z)};
  const double norm = geometry::Norm(normal);
  return norm > 0 ? normal / norm : Vec3{};
}

template <typename Visit>
void ForEachNormal(const KeyframeMap& map, const Visit& visit) {
  for (size_t k = 0; k < map.size(); ++k) {
    for (const KeyframePoint& point : map.points(k)) visit(NormalOf(point));
  }
}

Vec3 MeanImageUp(const KeyframeMap& map) {
  Vec3 sum;
  for (size_t k = 0; k < map.size(); ++k) {
    sum = sum + map.world_from_camera(k).rotation * Vec3{0, -1, 0};
  }
  const double norm = geometry::Norm(sum);
  return norm > 0 ? sum / norm : Vec3{0, 0, 1};
}

// The mean of the normals within `angle_rad` of `up`; `up` where there is none.
Vec3 MeanNormalNear(const KeyframeMap& map, Vec3 up, double angle_rad) {
  const double least = std::cos(angle_rad);
  Vec3 sum;
  ForEachNormal(map, [&](Vec3 normal) {
    if (geometry::Dot(normal, up) > least) sum = sum + normal;
  });
  const double norm = geometry::Norm(sum);
  return norm > 0 ? sum / norm : up;
}

Vec3 UpOf(const KeyframeMap& map) {
  Vec3 up = MeanImageUp(map);
  for (double angle_rad = kMaxUpError_rad; angle_rad > kMinUpError_rad;
       angle_rad *= 0.8) {
    up = MeanNormalNear(map, up, angle_rad);
  }
  for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
    const double along = geometry::Dot(axis, up);
    if (std::abs(along) > std::cos(kAxisError_rad)) {
      return along > 0 ? axis : -axis;
    }
  }
  return up;
}

// A plan with z up, turned anyhow.
geometry::Rotation3 AnyPlan(Vec3 up) {
  const Vec3 along =
      std::abs(up.x) < std::abs(up.y) ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 x = geometry::Normalized(along - geometry::Dot(along, up) * up);
  const Vec3 y = geometry::Cross(up, x);
  return geometry::Rotation3::FromMatrix(
      geometry::Mat3{{x.x, x.y, x.z, y.x, y.y, y.z, up.x, up.y, up.z}});
}

// The turn about z after which most walls are parallel to x or y. Walls repeat
// at right angles, so four times their directions are averaged.
double TurnToWalls_rad(const KeyframeMap& map,
                       const geometry::Rotation3& plan_from_world) {
  const geometry::Mat3 matrix = plan_from_world.Matrix();
  double sine = 0;
  double cosine = 0;
  ForEachNormal(map, [&](Vec3 normal_in_world) {
    const Vec3 normal = matrix * normal_in_world;
    const double level = std::hypot(normal.x, normal.y);
    if (!(level > kMinWallNormal)) return;
    const double angle = 4 * std::atan2(normal.y, normal.x);
    sine += std::sin(angle);
    cosine += std::cos(angle);
  });
  return -std::atan2(sine, cosine) / 4;
}

}  // namespace

geometry::Rotation3 PlanFromWorld(const KeyframeMap& map) {
  const Vec3 up = UpOf(map);
  if (up == Vec3{0, 0, 1}) return {};
  const geometry::Rotation3 any = AnyPlan(up);
  return geometry::Rotation3::FromAxisAngle({0, 0, TurnToWalls_rad(map, any)}) *
         any;
}

}  // namespace treeline::keyframes
