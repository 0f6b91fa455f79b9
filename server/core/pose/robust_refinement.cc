#include "server/core/pose/robust_refinement.h"

#include "Eigen/Cholesky"
#include "Eigen/Core"

namespace treeline::pose {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Matrix6 Hessian(const NormalEquations& equations) {
  Matrix6 h = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(
      equations.hessian.data());
  h.triangularView<Eigen::StrictlyLower>() = h.transpose();
  return h;
}

geometry::Rigid3 Moved(const geometry::Rigid3& pose, const Vector6& step) {
  return {geometry::Normalized(
              geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]}) *
              pose.rotation),
          pose.translation + geometry::Vec3{step[0], step[1], step[2]}};
}

}  // namespace

std::optional<geometry::Rigid3> SolveStep(
    const NormalEquations& equations, double damping, double min_rcond,
    const geometry::Rigid3& world_from_camera) {
  const Eigen::Map<const Vector6> g(equations.gradient.data());
  Matrix6 h = Hessian(equations);
  h.diagonal() *= 1 + damping;
  const Eigen::LDLT<Matrix6> factors(h);
  if (factors.info() != Eigen::Success || !(factors.rcond() > min_rcond)) {
    return std::nullopt;
  }
  return Moved(world_from_camera, -factors.solve(g));
}

geometry::PoseCovariance CovarianceOf(const RobustSum& sum) {
  const double degrees = std::max(1.0, sum.residuals - 6);
  const Matrix6 inverse =
      Hessian(sum.equations).ldlt().solve(Matrix6::Identity()) *
      std::max(1.0, sum.value / degrees);
  geometry::PoseCovariance covariance{};
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) {
      covariance[static_cast<size_t>(6 * r + c)] =
          0.5 * (inverse(r, c) + inverse(c, r));
    }
  }
  return covariance;
}

}  // namespace treeline::pose
