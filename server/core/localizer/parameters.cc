#include "server/core/localizer/parameters.h"

namespace treeline::localizer {

std::vector<base::ParameterRow> LocalizerParameters() {
  return {base::RowOf(kPriorSigma_m),
          base::RowOf(kPriorSamples),
          base::RowOf(kMinForestSamples),
          base::RowOf(kForestRansacInlier_px),
          base::RowOf(kForestRobustScale_px),
          base::RowOf(kForestInlier_px),
          base::RowOf(kPointLineModelSigma_m),
          base::RowOf(kPointLineHypothesisIterations),
          base::RowOf(kMatchedKeyframes),
          base::RowOf(kMatchedLikeKeyframes),
          base::RowOf(kMaxQueryFeatures),
          base::RowOf(kMaxFastQueryFeatures),
          base::RowOf(kMaxKeyframeRatio),
          base::RowOf(kMaxPriorKeyframeDistance_m),
          base::RowOf(kMinKeyframeMatches),
          base::RowOf(kMinKeyframeInliers),
          base::RowOf(kKeypointSigma_px),
          base::RowOf(kKeyframePointSigma_m),
          base::RowOf(kKeyframeRansacInlier_px),
          base::RowOf(kKeyframeRobustScale_px),
          base::RowOf(kKeyframeInlier_px),
          base::RowOf(kMaxSiftRatio),
          base::RowOf(kSameSiftPlace),
          base::RowOf(kMinSiftMatches),
          base::RowOf(kSiftRansacInlier_px),
          base::RowOf(kSiftRobustScale_px),
          base::RowOf(kSiftInlier_px),
          base::RowOf(kSufficientConfidence),
          base::RowOf(kMinAnswerInliers),
          base::RowOf(kMinKeyframeOverlap),
          base::RowOf(kMaxPositionSigma_m),
          base::RowOf(kMinSiftInliers),
          base::RowOf(kFewMatches),
          base::RowOf(kMaxRelativePositionSigma),
          base::RowOf(kMinFocalError),
          base::RowOf(kMinFocalSigmas),
          base::RowOf(kMinDoubtfulFocalSigmas),
          base::RowOf(kSameFocal),
          base::RowOf(kMaxFocalRounds),
          base::RowOf(kOtherTurnOdds)};
}

}  // namespace treeline::localizer
