#include "common/wire/geometry.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace treeline::wire {
namespace {

// A dozen rounding errors of a norm near 1.
constexpr double kUnitToRounding = 4e-15;

}  // namespace

absl::Status FieldError(absl::string_view field, absl::string_view problem) {
  return absl::InvalidArgumentError(absl::StrCat(field, ": ", problem));
}

v1::Vector3 ToProto(geometry::Vec3 v) {
  v1::Vector3 proto;
  proto.set_x(v.x);
  proto.set_y(v.y);
  proto.set_z(v.z);
  return proto;
}

absl::StatusOr<geometry::Vec3> FromProto(const v1::Vector3& proto,
                                         absl::string_view field) {
  const geometry::Vec3 v{proto.x(), proto.y(), proto.z()};
  if (!geometry::IsFinite(v))
    return FieldError(field, "has a NaN or an infinity");
  return v;
}

v1::Pixel ToProto(camera::Pixel pixel) {
  v1::Pixel proto;
  proto.set_x_px(pixel.x);
  proto.set_y_px(pixel.y);
  return proto;
}

camera::Pixel FromProto(const v1::Pixel& proto) {
  return {proto.x_px(), proto.y_px()};
}

v1::Quaternion ToProto(const geometry::Rotation3& target_from_source) {
  v1::Quaternion proto;
  proto.set_w(target_from_source.w);
  proto.set_x(target_from_source.x);
  proto.set_y(target_from_source.y);
  proto.set_z(target_from_source.z);
  return proto;
}

v1::Pose ToProto(const geometry::Rigid3& target_from_source) {
  v1::Pose proto;
  *proto.mutable_rotation() = ToProto(target_from_source.rotation);
  *proto.mutable_translation_m() = ToProto(target_from_source.translation);
  return proto;
}

absl::StatusOr<geometry::Rigid3> FromProto(const v1::Pose& proto,
                                           absl::string_view field) {
  if (!proto.has_rotation()) return FieldError(field, "has no rotation");
  const v1::Quaternion& q = proto.rotation();
  const geometry::Vec3 translation{proto.translation_m().x(),
                                   proto.translation_m().y(),
                                   proto.translation_m().z()};
  absl::StatusOr<geometry::Rigid3> pose =
      geometry::RigidFromQuaternion(q.w(), q.x(), q.y(), q.z(), translation);
  if (!pose.ok()) {
    return FieldError(field, {pose.status().message().data(),
                              pose.status().message().size()});
  }
  const double norm =
      std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
  if (std::abs(norm - 1) <= kUnitToRounding) {
    pose->rotation = {q.w(), q.x(), q.y(), q.z()};
  }
  return pose;
}

}  // namespace treeline::wire
