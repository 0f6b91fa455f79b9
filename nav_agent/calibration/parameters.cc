#include "nav_agent/calibration/parameters.h"

namespace treeline::calibration {

std::vector<base::ParameterRow> CalibrationParameters() {
  return {base::RowOf(kScanSpacing_s),   base::RowOf(kClockJump_s),
          base::RowOf(kLongestGap_s),    base::RowOf(kUsualGaps),
          base::RowOf(kLongestWait_s),   base::RowOf(kDelayInterval_s),
          base::RowOf(kWindowWay_m),     base::RowOf(kWindowTurn_rad),
          base::RowOf(kStillWay_m),      base::RowOf(kStillTurn_rad),
          base::RowOf(kLongestWindow_s), base::RowOf(kSearchWay_m),
          base::RowOf(kSearchTurn_rad),  base::RowOf(kMatchRange_m),
          base::RowOf(kMinResponse),     base::RowOf(kAgree_m),
          base::RowOf(kAgree_rad),       base::RowOf(kMatchNoise_m),
          base::RowOf(kMatchNoise_rad),  base::RowOf(kMatchBias_m),
          base::RowOf(kMatchBias_rad),   base::RowOf(kCameraBias_m),
          base::RowOf(kDepthShare),      base::RowOf(kDelayBias_s),
          base::RowOf(kMinMotions),      base::RowOf(kMaxMotions),
          base::RowOf(kPriorScale),      base::RowOf(kPriorMount_m),
          base::RowOf(kPriorYaw_rad),    base::RowOf(kPriorDelay_s),
          base::RowOf(kKnownScale),      base::RowOf(kKnownTrack),
          base::RowOf(kKnownMount_m),    base::RowOf(kKnownYaw_rad),
          base::RowOf(kKnownDelay_s),    base::RowOf(kFitsScale),
          base::RowOf(kFitsMount_m),     base::RowOf(kFitsYaw_rad),
          base::RowOf(kFitsDelay_s),     base::RowOf(kFitsNoise),
          base::RowOf(kFitsSigmas),      base::RowOf(kCauchySigmas),
          base::RowOf(kOutlierSigmas),   base::RowOf(kBlocks),
          base::RowOf(kNoiseFloor)};
}

}  // namespace treeline::calibration
