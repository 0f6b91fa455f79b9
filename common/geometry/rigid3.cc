#include "common/geometry/rigid3.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Core"
#include "Eigen/LU"
#include "Eigen/SVD"
#include "absl/strings/str_cat.h"

namespace treeline::geometry {

Mat3 Rotation3::Matrix() const {
  return Mat3{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z),
               2 * (x * z + w * y),  //
               2 * (x * y + w * z), 1 - 2 * (x * x + z * z),
               2 * (y * z - w * x),  //
               2 * (x * z - w * y), 2 * (y * z + w * x),
               1 - 2 * (x * x + y * y)}};
}

Rotation3 Rotation3::FromAxisAngle(Vec3 axis_angle_rad) {
  const double angle = Norm(axis_angle_rad);
  // sin(a/2)/a, by its series where the quotient would lose digits.
  const double scale =
      angle < 1e-6 ? 0.5 - angle * angle / 48 : std::sin(angle / 2) / angle;
  return {std::cos(angle / 2), scale * axis_angle_rad.x,
          scale * axis_angle_rad.y, scale * axis_angle_rad.z};
}

Rotation3 Rotation3::FromMatrix(const Mat3& a) {
  // Shepperd's method: divide by the largest of the four components.
  const double trace = a(0, 0) + a(1, 1) + a(2, 2);
  Rotation3 q;
  if (trace >= std::max({a(0, 0), a(1, 1), a(2, 2)})) {
    q = {1 + trace, a(2, 1) - a(1, 2), a(0, 2) - a(2, 0), a(1, 0) - a(0, 1)};
  } else if (a(0, 0) >= std::max(a(1, 1), a(2, 2))) {
    q = {a(2, 1) - a(1, 2), 1 + 2 * a(0, 0) - trace, a(0, 1) + a(1, 0),
         a(0, 2) + a(2, 0)};
  } else if (a(1, 1) >= a(2, 2)) {
    q = {a(0, 2) - a(2, 0), a(0, 1) + a(1, 0), 1 + 2 * a(1, 1) - trace,
         a(1, 2) + a(2, 1)};
  } else {
    q = {a(1, 0) - a(0, 1), a(0, 2) + a(2, 0), a(1, 2) + a(2, 1),
         1 + 2 * a(2, 2) - trace};
  }
  return Normalized(q);
}

Rotation3 operator*(const Rotation3& a, const Rotation3& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
          a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

Vec3 operator*(const Rotation3& a, Vec3 v) {
  const Vec3 u{a.x, a.y, a.z};
  const Vec3 t = 2 * Cross(u, v);
  return v + a.w * t + Cross(u, t);
}

Vec3 ToAxisAngle(const Rotation3& a) {
  const Rotation3 q = Normalized(a);
  const Vec3 v{q.x, q.y, q.z};
  const double sine = Norm(v);
  if (sine < 1e-9) return 2 * v;
  return (2 * std::atan2(sine, q.w) / sine) * v;
}

double AngleBetween_rad(const Rotation3& a, const Rotation3& b) {
  return Norm(ToAxisAngle(a.Inverse() * b));
}

Rotation3 Normalized(const Rotation3& a) {
  const double norm = std::sqrt(a.w * a.w + a.x * a.x + a.y * a.y + a.z * a.z);
  const double s = (a.w < 0 ? -1 : 1) / norm;
  return {s * a.w, s * a.x, s * a.y, s * a.z};
}

Rotation3 Slerp(const Rotation3& a, const Rotation3& b, double t) {
  return Normalized(a *
                    Rotation3::FromAxisAngle(t * ToAxisAngle(a.Inverse() * b)));
}

Rigid3 Rigid3::Inverse() const {
  const Rotation3 inverse = rotation.Inverse();
  return {inverse, -(inverse * translation)};
}

Rigid3 operator*(const Rigid3& a, const Rigid3& b) {
  return {Normalized(a.rotation * b.rotation),
          a.rotation * b.translation + a.translation};
}

Vec3 operator*(const Rigid3& a, Vec3 point) {
  return a.rotation * point + a.translation;
}

absl::StatusOr<Rigid3> RigidFromMatrix4(const std::array<double, 16>& matrix) {
  for (double entry : matrix) {
    if (!std::isfinite(entry)) {
      return absl::InvalidArgumentError("pose matrix has a NaN or infinity");
    }
  }
  if (std::abs(matrix[12]) + std::abs(matrix[13]) + std::abs(matrix[14]) +
          std::abs(matrix[15] - 1) >
      1e-6) {
    return absl::InvalidArgumentError(
        "pose matrix is not rigid: its last row is not 0 0 0 1");
  }
  Eigen::Matrix3d linear;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      linear(r, c) = matrix[static_cast<size_t>(4 * r + c)];
    }
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d scales = svd.singularValues();
  if (linear.determinant() <= 0 || scales.minCoeff() < 0.95 ||
      scales.maxCoeff() > 1.05) {
    return absl::InvalidArgumentError(absl::StrCat(
        "pose matrix is not rigid: its axes are scaled by ", scales[0], " ",
        scales[1], " ", scales[2], ", determinant ", linear.determinant()));
  }
  const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  Mat3 rotation;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) rotation(r, c) = nearest(r, c);
  }
  return Rigid3{Rotation3::FromMatrix(rotation),
                {matrix[3], matrix[7], matrix[11]}};
}

absl::StatusOr<Rigid3> RigidFromQuaternion(double qw, double qx, double qy,
                                           double qz, Vec3 translation_m) {
  const double norm = std::sqrt(qw * qw + qx * qx + qy * qy + qz * qz);
  if (!std::isfinite(norm) || !IsFinite(translation_m)) {
    return absl::InvalidArgumentError("pose has a NaN or infinity");
  }
  if (std::abs(norm - 1) > 1e-2) {
    return absl::InvalidArgumentError(
        absl::StrCat("pose quaternion has norm ", norm, ", not 1"));
  }
  return Rigid3{Normalized(Rotation3{qw, qx, qy, qz}), translation_m};
}

bool IsFinite(const Rigid3& transform) {
  const Rotation3& q = transform.rotation;
  return IsFinite(transform.translation) && IsFinite(Vec3{q.x, q.y, q.z}) &&
         std::isfinite(q.w);
}

PoseError ErrorBetween(const Rigid3& estimated_world_from_camera,
                       const Rigid3& true_world_from_camera) {
  return {Norm(estimated_world_from_camera.translation -
               true_world_from_camera.translation),
          AngleBetween_rad(estimated_world_from_camera.rotation,
                           true_world_from_camera.rotation)};
}

}  // namespace treeline::geometry
