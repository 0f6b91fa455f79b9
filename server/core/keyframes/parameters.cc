#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {

std::vector<base::ParameterRow> KeyframeParameters() {
  return {base::RowOf(kViewDistance_m),
          base::RowOf(kCoarsePoints),
          base::RowOf(kSameView_m),
          base::RowOf(kMinPointDepth_m),
          base::RowOf(kMinFacing),
          base::RowOf(kMinVisible),
          base::RowOf(kMinBrightnessNoise),
          base::RowOf(kMaxBrightnessNoise),
          base::RowOf(kAgreeingBrightness),
          base::RowOf(kExposureCells),
          base::RowOf(kMinExposurePoints),
          base::RowOf(kMinExposureCorrelation),
          base::RowOf(kMaxGain),
          base::RowOf(kCorrelatedPoints),
          base::RowOf(kSurfaceNoise_m),
          base::RowOf(kMaxSurfaceDistance_m),
          base::RowOf(kSurfaceLevel),
          base::RowOf(kHalvedSide_px),
          base::RowOf(kSiftContrast),
          base::RowOf(kMaxFastFeatures),
          base::RowOf(kCoarseFrameFeatures),
          base::RowOf(kCoarseKeyframeFeatures),
          base::RowOf(kShortlist),
          base::RowOf(kFrameFeatures),
          base::RowOf(kMaxKeyframeFeatures),
          base::RowOf(kMinSharedFeatures),
          base::RowOf(kIndexedFeatures),
          base::RowOf(kIndexQueries),
          base::RowOf(kFeaturesPerWord),
          base::RowOf(kMaxKinds),
          base::RowOf(kWordSamples),
          base::RowOf(kWordRounds),
          base::RowOf(kMaxDifferentBits),
          base::RowOf(kDifferentBits)};
}

}  // namespace treeline::keyframes
