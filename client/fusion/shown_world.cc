#include "client/fusion/shown_world.h"

#include "client/fusion/gaussian_pose.h"
#include "client/fusion/radians.h"

namespace treeline::drift {
namespace {

using geometry::Rigid3;

// How much of a length is done, where `most` may be.
double ShareOf(double length, double most) {
  return length > most ? most / length : 1;
}

}  // namespace

bool ShownWorld::Step(const Rigid3& world_from_camera,
                      const Rigid3& device_from_camera, double passed_s) {
  const Rigid3 camera_from_device = device_from_camera.Inverse();
  const Rigid3 known = world_from_camera * camera_from_device;
  if (!world_from_device_.has_value()) {
    world_from_device_ = known;
    return true;
  }
  const Rigid3 shown = *world_from_device_ * device_from_camera;
  const PoseDelta delta = Difference(shown, world_from_camera);
  const double distance_m = Norm(delta.translation_m);
  const double angle_rad = Norm(delta.rotation_rad);
  if (distance_m > options_.snap_m || angle_rad > Radians(options_.snap_deg)) {
    world_from_device_ = known;
    return true;
  }
  // Each for itself: a rotation that waited for a long way would make new
  // errors of position as the camera moves on.
  const double move =
      ShareOf(distance_m, options_.max_correction_mps * passed_s);
  const double turn =
      ShareOf(angle_rad, Radians(options_.max_correction_degps) * passed_s);
  world_from_device_ =
      Moved(shown, {move * delta.translation_m, turn * delta.rotation_rad}) *
      camera_from_device;
  return false;
}

}  // namespace treeline::drift
