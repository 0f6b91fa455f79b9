#include "client/fusion/gaussian_pose.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "Eigen/Cholesky"
#include "Eigen/Core"

namespace treeline::drift {
namespace {

using geometry::PoseCovariance;
using geometry::Rigid3;
using geometry::Vec3;

using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// What rounding does to a covariance, as a share of its largest variance and in
// m^2 or rad^2: a deviation of 0.03 mm.
constexpr double kRounding = 1e-9;

Eigen::Map<const Matrix6> MatrixOf(const PoseCovariance& covariance) {
  return Eigen::Map<const Matrix6>(covariance.data());
}

PoseCovariance CovarianceOf(const Matrix6& matrix) {
  PoseCovariance covariance;
  Eigen::Map<Matrix6>(covariance.data()) = matrix;
  return covariance;
}

Vector6 VectorOf(const PoseDelta& delta) {
  Vector6 vector;
  vector << delta.translation_m.x, delta.translation_m.y, delta.translation_m.z,
      delta.rotation_rad.x, delta.rotation_rad.y, delta.rotation_rad.z;
  return vector;
}

double SigmaOf(const PoseCovariance& covariance, size_t first) {
  return std::sqrt(std::max({covariance[7 * first], covariance[7 * first + 7],
                             covariance[7 * first + 14]}));
}

}  // namespace

PoseCovariance Diagonal(double position_variance_m2,
                        double rotation_variance_rad2) {
  PoseCovariance covariance{};
  for (size_t i = 0; i < 6; ++i) {
    covariance[7 * i] = i < 3 ? position_variance_m2 : rotation_variance_rad2;
  }
  return covariance;
}

PoseCovariance Sum(const PoseCovariance& a, const PoseCovariance& b) {
  PoseCovariance sum;
  std::ranges::transform(a, b, sum.begin(), std::plus<>());
  return sum;
}

PoseCovariance Scaled(const PoseCovariance& covariance, double factor) {
  PoseCovariance scaled;
  std::ranges::transform(covariance, scaled.begin(),
                         [factor](double value) { return factor * value; });
  return scaled;
}

bool IsCovariance(const PoseCovariance& covariance) {
  const Eigen::Map<const Matrix6> matrix = MatrixOf(covariance);
  if (!matrix.allFinite()) return false;
  const double tolerance =
      kRounding * std::max(1.0, matrix.diagonal().maxCoeff());
  if ((matrix - matrix.transpose()).cwiseAbs().maxCoeff() > tolerance) {
    return false;
  }
  const Matrix6 raised = matrix + tolerance * Matrix6::Identity();
  return raised.llt().info() == Eigen::Success;
}

PoseCovariance Transported(const PoseCovariance& covariance,
                           Vec3 moved_in_world) {
  const Vec3& m = moved_in_world;
  Matrix6 f = Matrix6::Identity();
  f.topRightCorner<3, 3>() << 0, m.z, -m.y, -m.z, 0, m.x, m.y, -m.x, 0;
  return CovarianceOf(f * MatrixOf(covariance) * f.transpose());
}

PoseDelta Difference(const Rigid3& a, const Rigid3& b) {
  return {b.translation - a.translation,
          geometry::ToAxisAngle(b.rotation * a.rotation.Inverse())};
}

Rigid3 Moved(const Rigid3& world_from_camera, const PoseDelta& delta) {
  return {
      geometry::Normalized(
          geometry::Rotation3::FromAxisAngle(delta.rotation_rad) *
          world_from_camera.rotation),
      world_from_camera.translation + delta.translation_m,
  };
}

double SquaredDistance(const GaussianPose& a, const GaussianPose& b) {
  const Matrix6 sum = MatrixOf(a.covariance) + MatrixOf(b.covariance);
  const Eigen::LLT<Matrix6> factor(sum);
  if (factor.info() != Eigen::Success) {
    return std::numeric_limits<double>::infinity();
  }
  const Vector6 r =
      VectorOf(Difference(a.world_from_camera, b.world_from_camera));
  return factor.matrixL().solve(r).squaredNorm();
}

GaussianPose Fused(const GaussianPose& a, const GaussianPose& b) {
  const Matrix6 before = MatrixOf(a.covariance);
  const Matrix6 sum = before + MatrixOf(b.covariance);
  // K^T = (A + B)^-1 A, since both are symmetric.
  const Matrix6 gain = sum.llt().solve(before).transpose();
  const Vector6 r =
      VectorOf(Difference(a.world_from_camera, b.world_from_camera));
  const Vector6 delta = gain * r;
  const Matrix6 after = before - gain * before;
  return {Moved(a.world_from_camera, {{delta[0], delta[1], delta[2]},
                                      {delta[3], delta[4], delta[5]}}),
          CovarianceOf(0.5 * (after + after.transpose()))};
}

double PositionSigma_m(const PoseCovariance& covariance) {
  return SigmaOf(covariance, 0);
}

double RotationSigma_rad(const PoseCovariance& covariance) {
  return SigmaOf(covariance, 3);
}

}  // namespace treeline::drift
