#include "server/core/pose/parameters.h"

namespace treeline::pose {

std::vector<base::ParameterRow> PoseParameters() {
  return {base::RowOf(kInitialRobustScale),
          base::RowOf(kRobustReach),
          base::RowOf(kMinRobustWeights),
          base::RowOf(kMinPointRcond),
          base::RowOf(kMinRayRcond),
          base::RowOf(kMinDamping),
          base::RowOf(kDampingFactor),
          base::RowOf(kMaxDampedSteps),
          base::RowOf(kFinalRefits),
          base::RowOf(kMaxScoredSlide_m),
          base::RowOf(kMaxRefinedPointLinePoses),
          base::RowOf(kMinRaySide),
          base::RowOf(kMaxRefinedRayPoses),
          base::RowOf(kLocalRayIterations),
          base::RowOf(kFocalIterations),
          base::RowOf(kPointFocalIterations),
          base::RowOf(kInitialPointFocalRobustScale),
          base::RowOf(kPointFocalBias),
          base::RowOf(kDepthScaleSigma),
          base::RowOf(kInitialFocalRobustScale),
          base::RowOf(kMaxLogFocalScale)};
}

}  // namespace treeline::pose
