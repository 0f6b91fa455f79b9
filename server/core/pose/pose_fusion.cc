#include "server/core/pose/pose_fusion.h"

#include "Eigen/Cholesky"
#include "Eigen/Core"

namespace treeline::pose {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kMinRcond = 1e-14;

std::optional<Matrix6> InverseOf(const Matrix6& matrix) {
  if (!matrix.allFinite()) return std::nullopt;
  const Eigen::LDLT<Matrix6> factors(matrix);
  if (factors.info() != Eigen::Success || !factors.isPositive() ||
      !(factors.rcond() > kMinRcond)) {
    return std::nullopt;
  }
  return factors.solve(Matrix6::Identity());
}

// What turns and moves `from` into `to`: see PoseCovariance.
Vector6 Difference(const geometry::Rigid3& from, const geometry::Rigid3& to) {
  const geometry::Vec3 t = to.translation - from.translation;
  const geometry::Vec3 r =
      geometry::ToAxisAngle(to.rotation * from.rotation.Inverse());
  Vector6 difference;
  difference << t.x, t.y, t.z, r.x, r.y, r.z;
  return difference;
}

}  // namespace

std::optional<PoseWithCovariance> FusePoses(const PoseWithCovariance& a,
                                            const PoseWithCovariance& b) {
  const auto information_a =
      InverseOf(Eigen::Map<const Matrix6>(a.covariance.data()));
  const auto information_b =
      InverseOf(Eigen::Map<const Matrix6>(b.covariance.data()));
  if (!information_a || !information_b) return std::nullopt;
  const auto covariance = InverseOf(*information_a + *information_b);
  if (!covariance) return std::nullopt;
  const Vector6 step =
      *covariance *
      (*information_b * Difference(a.world_from_camera, b.world_from_camera));
  PoseWithCovariance fused;
  fused.world_from_camera = {
      geometry::Normalized(
          geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]}) *
          a.world_from_camera.rotation),
      a.world_from_camera.translation +
          geometry::Vec3{step[0], step[1], step[2]}};
  Eigen::Map<Matrix6>(fused.covariance.data()) = *covariance;
  return fused;
}

}  // namespace treeline::pose
