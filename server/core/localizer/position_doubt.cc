#include "server/core/localizer/position_doubt.h"

#include <cmath>
#include <cstddef>

#include "Eigen/Core"
#include "Eigen/Eigenvalues"
#include "server/core/localizer/parameters.h"

namespace treeline::localizer {

geometry::PoseCovariance Widened(const geometry::PoseCovariance& covariance,
                                 double factor) {
  geometry::PoseCovariance widened = covariance;
  for (double& entry : widened) entry *= factor * factor;
  return widened;
}

geometry::PoseCovariance Sum(const geometry::PoseCovariance& a,
                             const geometry::PoseCovariance& b) {
  geometry::PoseCovariance sum = a;
  for (size_t i = 0; i < sum.size(); ++i) sum[i] += b[i];
  return sum;
}

double ProbabilityNear(const geometry::PoseCovariance& covariance) {
  const Eigen::Matrix3d position =
      Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(
          covariance.data())
          .topLeftCorner<3, 3>();
  if (!position.allFinite()) return 0;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
      position, Eigen::EigenvaluesOnly);
  const double variance = axes.eigenvalues()[2];
  if (!(variance > 0)) return 1;
  return std::erf(kApart_m / std::sqrt(2 * variance));
}

void WeighDoubt(const std::optional<geometry::PoseCovariance>& of_features,
                const std::optional<geometry::PoseCovariance>& camera,
                double scale, double min_confidence, PoseEstimate& estimate) {
  if (of_features) {
    estimate.covariance = Widened(estimate.covariance, scale);
    estimate.confidence *=
        camera ? ProbabilityNear(Sum(*of_features, Widened(*camera, scale)))
               : 0;
  }
  if (camera) {
    estimate.covariance = Sum(estimate.covariance, Widened(*camera, scale));
  }
  if (estimate.outcome == Outcome::kLocalized &&
      estimate.confidence < min_confidence) {
    estimate.outcome = Outcome::kNotLocalized;
    estimate.reason = NotLocalizedReason::kPoorlyConstrained;
  }
}

}  // namespace treeline::localizer
