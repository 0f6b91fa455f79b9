// Vectors and poses, proto <-> C++.
#ifndef COMMON_WIRE_GEOMETRY_H_
#define COMMON_WIRE_GEOMETRY_H_

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "treeline/v1/geometry.pb.h"

namespace treeline::wire {

// INVALID_ARGUMENT about one field of a request: "<field>: <problem>".
absl::Status FieldError(absl::string_view field, absl::string_view problem);

v1::Vector3 ToProto(geometry::Vec3 v);
// INVALID_ARGUMENT naming `field` for a NaN or an infinity.
absl::StatusOr<geometry::Vec3> FromProto(const v1::Vector3& proto,
                                         absl::string_view field);

v1::Pixel ToProto(camera::Pixel pixel);
camera::Pixel FromProto(const v1::Pixel& proto);

v1::Quaternion ToProto(const geometry::Rotation3& target_from_source);
v1::Pose ToProto(const geometry::Rigid3& target_from_source);
// A quaternion that is unit to rounding is kept bit for bit, so that a pose
// survives the wire unchanged; one within 0.01 of unit is normalised.
// INVALID_ARGUMENT naming `field`: no rotation, another norm, a NaN or an
// infinity.
absl::StatusOr<geometry::Rigid3> FromProto(const v1::Pose& proto,
                                           absl::string_view field);

}  // namespace treeline::wire

#endif  // COMMON_WIRE_GEOMETRY_H_
