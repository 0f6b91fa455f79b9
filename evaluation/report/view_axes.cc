#include "evaluation/report/view_axes.h"

#include <cmath>

namespace treeline::report {
namespace {

// `v`, or `fallback` where v has no direction to speak of.
geometry::Vec3 DirectionOr(geometry::Vec3 v, geometry::Vec3 fallback) {
  return geometry::Norm(v) > 1e-6 ? geometry::Normalized(v) : fallback;
}

geometry::Vec3 WithoutComponent(geometry::Vec3 v, geometry::Vec3 unit) {
  return v - geometry::Dot(v, unit) * unit;
}

}  // namespace

ViewAxes AxesOfCameras(const std::vector<geometry::Rigid3>& world_from_camera) {
  geometry::Vec3 up;
  geometry::Vec3 forward;
  for (const geometry::Rigid3& pose : world_from_camera) {
    up = up - pose.rotation * geometry::Vec3{0, 1, 0};
    forward = forward + pose.rotation * geometry::Vec3{0, 0, 1};
  }
  ViewAxes axes;
  axes.up_in_world = DirectionOr(up, {0, 0, 1});
  const geometry::Vec3 other = std::abs(axes.up_in_world.x) < 0.7
                                   ? geometry::Vec3{1, 0, 0}
                                   : geometry::Vec3{0, 1, 0};
  axes.forward_in_world = DirectionOr(
      WithoutComponent(forward, axes.up_in_world),
      geometry::Normalized(WithoutComponent(other, axes.up_in_world)));
  axes.right_in_world =
      geometry::Cross(axes.forward_in_world, axes.up_in_world);
  return axes;
}

}  // namespace treeline::report
