#include "common/geometry/kabsch.h"

#include "Eigen/Eigenvalues"

namespace treeline::geometry {

void Kabsch::Add(Vec3 point_in_a, Vec3 point_in_b, double weight) {
  if (count_ == 0) {
    origin_in_a_ = point_in_a;
    origin_in_b_ = point_in_b;
  }
  ++count_;
  const Vec3 a = point_in_a - origin_in_a_;
  const Vec3 b = point_in_b - origin_in_b_;
  const Vec3 wa = weight * a;
  weight_ += weight;
  sum_a_ = sum_a_ + wa;
  sum_b_ = sum_b_ + weight * b;
  for (int j = 0; j < 3; ++j) {
    products_(0, j) += wa.x * b[j];
    products_(1, j) += wa.y * b[j];
    products_(2, j) += wa.z * b[j];
  }
}

std::optional<Rigid3> Kabsch::Solve() const {
  if (count_ < 3 || !(weight_ > 0)) return std::nullopt;
  const Vec3 mean_a = sum_a_ / weight_;
  const Vec3 mean_b = sum_b_ / weight_;
  Mat3 s;  // covariance of b with a: s(i, j) = sum w b_i a_j
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      s(i, j) = products_(j, i) - weight_ * mean_a[j] * mean_b[i];
    }
  }
  Eigen::Matrix4d n;
  n << s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2),
      s(0, 1) - s(1, 0),  //
      s(1, 2) - s(2, 1), s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0),
      s(2, 0) + s(0, 2),  //
      s(2, 0) - s(0, 2), s(0, 1) + s(1, 0), s(1, 1) - s(0, 0) - s(2, 2),
      s(1, 2) + s(2, 1),  //
      s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1),
      s(2, 2) - s(0, 0) - s(1, 1);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(n);
  // The two largest eigenvalues coincide when the points lie on a line: then
  // any rotation about it does.
  const Eigen::Vector4d& values = solver.eigenvalues();
  if (!(values[3] - values[2] > 1e-9 * values[3])) return std::nullopt;
  const Eigen::Vector4d q = solver.eigenvectors().col(3);
  const Rotation3 rotation = Normalized(Rotation3{q[0], q[1], q[2], q[3]});
  return Rigid3{rotation,
                (origin_in_a_ + mean_a) - rotation * (origin_in_b_ + mean_b)};
}

}  // namespace treeline::geometry
