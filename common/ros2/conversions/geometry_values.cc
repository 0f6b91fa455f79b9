#include "common/ros2/conversions/geometry_values.h"

#include <chrono>

#include "absl/status/status.h"

namespace treeline::conversions {
namespace {

// On the ground nothing is farther away than a quarter of the way round the
// earth, as in UTM; cells of maps are counted to there.
constexpr double kFarthest_m = 1e7;

absl::StatusOr<geometry::Rigid3> RigidFrom(const messages::Quaternion& q,
                                           geometry::Vec3 translation_m) {
  if (geometry::Norm(translation_m) > kFarthest_m) {
    return absl::InvalidArgumentError("pose is more than 10,000 km away");
  }
  if (q.x == 0 && q.y == 0 && q.z == 0 && q.w == 0) {
    return geometry::RigidFromQuaternion(1, 0, 0, 0, translation_m);
  }
  return geometry::RigidFromQuaternion(q.w, q.x, q.y, q.z, translation_m);
}

messages::Quaternion QuaternionOf(const geometry::Rotation3& rotation) {
  return {.x = rotation.x, .y = rotation.y, .z = rotation.z, .w = rotation.w};
}

}  // namespace

base::MonotonicTime TimeOf(const messages::Time& stamp) {
  return base::MonotonicTime(
      std::chrono::nanoseconds(messages::Nanoseconds(stamp)));
}

messages::Time StampOf(base::MonotonicTime time) {
  return messages::TimeOf(std::chrono::duration_cast<std::chrono::nanoseconds>(
                              time.time_since_epoch())
                              .count());
}

absl::StatusOr<geometry::Rigid3> RigidOf(const messages::Pose& pose) {
  return RigidFrom(pose.orientation,
                   {pose.position.x, pose.position.y, pose.position.z});
}

absl::StatusOr<geometry::Rigid3> RigidOf(const messages::Transform& transform) {
  const messages::Vector3& t = transform.translation;
  return RigidFrom(transform.rotation, {t.x, t.y, t.z});
}

messages::Pose PoseOf(const geometry::Rigid3& transform) {
  const geometry::Vec3& t = transform.translation;
  return {.position = {.x = t.x, .y = t.y, .z = t.z},
          .orientation = QuaternionOf(transform.rotation)};
}

messages::Transform TransformOf(const geometry::Rigid3& transform) {
  const geometry::Vec3& t = transform.translation;
  return {.translation = {.x = t.x, .y = t.y, .z = t.z},
          .rotation = QuaternionOf(transform.rotation)};
}

}  // namespace treeline::conversions
