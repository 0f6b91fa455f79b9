#include "server/core/localizer/pose_verifier.h"

#include <algorithm>
#include <cmath>

#include "server/core/localizer/parameters.h"

namespace treeline::localizer {

double PositionSigma_m(const geometry::PoseCovariance& covariance) {
  return std::sqrt(std::max({covariance[0], covariance[7], covariance[14]}));
}

bool IsBetter(const Verdict& a, const Verdict& b) {
  if (a.is_believed() != b.is_believed()) return a.is_believed();
  return a.confidence > b.confidence;
}

double OddsRatio(const Verdict& a, const Verdict& b) {
  const auto odds = [](const Verdict& verdict) {
    const double p = std::clamp(verdict.confidence, 1e-9, 1 - 1e-9);
    return p / (1 - p);
  };
  return odds(a) / odds(b);
}

bool AreApart(const Verdict& a, const Verdict& b) {
  const geometry::PoseError between =
      geometry::ErrorBetween(a.world_from_camera, b.world_from_camera);
  return between.translation_m > kApart_m || between.rotation_rad > kApart_rad;
}

NotLocalizedReason ReasonAgainst(const Grounds& grounds) {
  if (!grounds.has_enough_inliers) return NotLocalizedReason::kTooFewInliers;
  if (!grounds.is_determined) return NotLocalizedReason::kPoorlyConstrained;
  if (!grounds.fits_depth) return NotLocalizedReason::kContradictsDepth;
  if (!grounds.is_confident) return NotLocalizedReason::kLowConfidence;
  return NotLocalizedReason::kNone;
}

}  // namespace treeline::localizer
