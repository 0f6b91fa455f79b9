// Rotations and rigid transforms.
//
// A transform is named <target>_from_<source>; it maps points of the source
// frame into the target frame, and products read by matching neighbours:
//   point_in_world = world_from_camera * point_in_camera
#ifndef COMMON_GEOMETRY_RIGID3_H_
#define COMMON_GEOMETRY_RIGID3_H_

#include "absl/status/statusor.h"
#include "common/geometry/vector3.h"

namespace treeline::geometry {

// A rotation as a unit quaternion w + xi + yj + zk (Hamilton convention).
struct Rotation3 {
  double w = 1;
  double x = 0;
  double y = 0;
  double z = 0;

  constexpr bool operator==(const Rotation3&) const = default;
  constexpr Rotation3 Inverse() const { return {w, -x, -y, -z}; }
  Mat3 Matrix() const;

  // The rotation by |axis_angle| radians about axis_angle.
  static Rotation3 FromAxisAngle(Vec3 axis_angle_rad);
  // The rotation whose matrix is `matrix`, which must be orthonormal.
  static Rotation3 FromMatrix(const Mat3& matrix);
};

Rotation3 operator*(const Rotation3& a, const Rotation3& b);
Vec3 operator*(const Rotation3& a, Vec3 v);

// The angle of the rotation that takes a to b, in [0, pi] rad. Accurate for
// small angles too.
double AngleBetween_rad(const Rotation3& a, const Rotation3& b);

// The axis-angle vector (rad) of a rotation; its norm is in [0, pi].
Vec3 ToAxisAngle(const Rotation3& a);

// The same rotation with |q| = 1 and w >= 0.
Rotation3 Normalized(const Rotation3& a);

// The interpolation at fraction t in [0, 1] from a to b along the shorter arc.
Rotation3 Slerp(const Rotation3& a, const Rotation3& b, double t);

// A rotation followed by a translation (m).
struct Rigid3 {
  Rotation3 rotation;
  Vec3 translation;

  constexpr bool operator==(const Rigid3&) const = default;
  Rigid3 Inverse() const;
};

Rigid3 operator*(const Rigid3& a, const Rigid3& b);
Vec3 operator*(const Rigid3& a, Vec3 point);

// A pose read from a file: the rotation part of the row-major 4x4 `matrix` is
// projected onto the nearest rotation (polar decomposition), since recorded
// matrices are often slightly scaled. INVALID_ARGUMENT if entries are not
// finite, the last row is not 0 0 0 1, or the rotation part is further than
// 5 % from orthonormal or a reflection.
absl::StatusOr<Rigid3> RigidFromMatrix4(const std::array<double, 16>& matrix);

// A pose read from quaternion and translation. INVALID_ARGUMENT if an entry is
// not finite or the quaternion's norm is further than 1e-2 from 1.
absl::StatusOr<Rigid3> RigidFromQuaternion(double qw, double qx, double qy,
                                           double qz, Vec3 translation_m);

bool IsFinite(const Rigid3& transform);

// How far an estimated pose is from the truth.
struct PoseError {
  double translation_m = 0;
  double rotation_rad = 0;
};
PoseError ErrorBetween(const Rigid3& estimated_world_from_camera,
                       const Rigid3& true_world_from_camera);

// Covariance of a pose `a_from_b`, row-major 6x6 in the order x, y, z (m),
// then rotation about the x, y, z axes (rad): the true pose is
//   (Exp(rotation) * a_from_b.rotation, a_from_b.translation + translation)
// with (translation, rotation) zero-mean of this covariance; both are
// expressed in frame a. The order of ROS's PoseWithCovariance.
using PoseCovariance = std::array<double, 36>;

}  // namespace treeline::geometry

#endif  // COMMON_GEOMETRY_RIGID3_H_
