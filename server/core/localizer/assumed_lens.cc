#include "server/core/localizer/assumed_lens.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "Eigen/LU"
#include "common/base/status_macros.h"
#include "common/camera/derived_camera.h"
#include "server/core/localizer/parameters.h"

namespace treeline::localizer {
namespace {

// A usual lens on a whole picture, and any.
struct Priors {
  pose::LensPrior usual;
  pose::LensPrior any;
};

Priors PriorsOf(const camera::Camera& camera) {
  const double longer_side =
      std::max(camera.width(), camera.height()) / MeanFocal_px(camera);
  return {
      .usual = {.offset = kUsualOffset * longer_side, .radial = kUsualRadial},
      .any = {.offset = kAnyOffset * longer_side, .radial = kAnyRadial}};
}

// The odds that some of the lens's unknowns, of `count` from `first` on, are
// usual: those before features were seen times how much more probable it is
// after (Savage's and Dickey's ratio of densities).
double UsualOdds(const pose::LensEstimate& found, const Priors& priors,
                 int first, int count) {
  const Eigen::Map<const Eigen::Matrix3d> all(found.covariance.data());
  const Eigen::Vector3d at{found.offset_x, found.offset_y, found.radial};
  const Eigen::Vector3d usual{priors.usual.offset, priors.usual.offset,
                              priors.usual.radial};
  const Eigen::Vector3d any{priors.any.offset, priors.any.offset,
                            priors.any.radial};
  Eigen::MatrixXd covariance = all.block(first, first, count, count);
  covariance.diagonal() += usual.segment(first, count).cwiseAbs2();
  const double determinant = covariance.determinant();
  if (!(determinant > 0)) return 0;
  const Eigen::VectorXd mean = at.segment(first, count);
  const double squared_sigmas = mean.dot(covariance.ldlt().solve(mean));
  return kUsualLensOdds * any.segment(first, count).prod() /
         std::sqrt(determinant) * std::exp(-squared_sigmas / 2);
}

// What is added to a covariance if it is `b` with this probability, and else
// `a`.
geometry::PoseCovariance Mixed(const geometry::PoseCovariance& a,
                               const geometry::PoseCovariance& b,
                               double probability) {
  geometry::PoseCovariance mixed{};
  for (size_t i = 0; i < mixed.size(); ++i) {
    mixed[i] = (1 - probability) * a[i] + probability * b[i];
  }
  return mixed;
}

}  // namespace

std::optional<AssumedLens> FindAssumedLens(
    const pose::RayPredictions& scene,
    const geometry::Rigid3& world_from_camera, double robust_scale,
    const camera::Camera& assumed, double min_odds) {
  const Priors priors = PriorsOf(assumed);
  const auto estimate = [&](const pose::LensPrior& prior) {
    return pose::EstimateLens(scene, world_from_camera, robust_scale, prior);
  };
  std::optional<pose::LensEstimate> any = estimate(priors.any);
  if (!any) return std::nullopt;
  const double odds = UsualOdds(*any, priors, 0, 3);
  if (odds >= min_odds) {
    const std::optional<pose::LensEstimate> usual = estimate(priors.usual);
    if (!usual) return std::nullopt;
    any->added = Mixed(usual->added, any->added, 1 / (1 + odds));
    return AssumedLens{*any, true};
  }
  const bool is_straight = UsualOdds(*any, priors, 2, 1) >= kMinUsualLensOdds;
  const bool is_centred = UsualOdds(*any, priors, 0, 2) >= kMinUsualLensOdds;
  if (is_straight == is_centred) return AssumedLens{*any};
  const std::optional<pose::LensEstimate> one = estimate(
      {.offset = is_centred ? priors.usual.offset : priors.any.offset,
       .radial = is_straight ? priors.usual.radial : priors.any.radial});
  if (!one) return std::nullopt;
  return AssumedLens{*one};
}

absl::StatusOr<camera::Camera> WithLens(const camera::Camera& assumed,
                                        const pose::LensEstimate& found) {
  TL_ASSIGN_OR_RETURN(
      const camera::Camera bent,
      camera::WithRadialAdded(
          assumed, found.radial / (found.focal.scale * found.focal.scale)));
  TL_ASSIGN_OR_RETURN(const camera::Camera scaled,
                      camera::WithFocalScaled(bent, found.focal.scale));
  return camera::WithPrincipalPointMoved(scaled, found.offset_x * assumed.fx(),
                                         found.offset_y * assumed.fy());
}

}  // namespace treeline::localizer
