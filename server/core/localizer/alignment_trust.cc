#include "server/core/localizer/alignment_trust.h"

#include "server/core/localizer/parameters.h"
#include "server/core/localizer/pose_verifier.h"

namespace treeline::localizer {

bool IsDrawnAway(const Candidate& candidate, double moved_m) {
  if (!candidate.is_matched || candidate.pose->inliers < kSufficientMatches) {
    return false;
  }
  const double sigma_m = PositionSigma_m(candidate.pose->covariance);
  return sigma_m <= kMaxFirmSigma_m && moved_m > kDrawnAwaySigmas * sigma_m;
}

}  // namespace treeline::localizer
