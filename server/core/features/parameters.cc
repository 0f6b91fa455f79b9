#include "server/core/features/parameters.h"

namespace treeline::features {

std::vector<base::ParameterRow> FeatureParameters() {
  return {base::RowOf(kMinDepth_m),        base::RowOf(kMaxDepth_m),
          base::RowOf(kMaxDrawsPerSample), base::RowOf(kLsdScale),
          base::RowOf(kMinLsdSide_px),     base::RowOf(kDepthRadius_px),
          base::RowOf(kMaxSurfaceGap),     base::RowOf(kFirstDepth_m),
          base::RowOf(kDepthLookups),      base::RowOf(kMaxDepthMiss_px),
          base::RowOf(kLineHypotheses),    base::RowOf(kMaxLineDeviation),
          base::RowOf(kLineFitRounds)};
}

}  // namespace treeline::features
