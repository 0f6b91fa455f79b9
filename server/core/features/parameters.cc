#include "server/core/features/parameters.h"

namespace treeline::features {

std::vector<base::ParameterRow> FeatureParameters() {
  return {base::RowOf(kMinDepth_m),         base::RowOf(kMaxDepth_m),
          base::RowOf(kMaxDrawsPerSample),  base::RowOf(kLsdScale),
          base::RowOf(kMinLsdSide_px),      base::RowOf(kDepthRadius_px),
          base::RowOf(kMaxSurfaceGap),      base::RowOf(kFirstDepth_m),
          base::RowOf(kDepthLookups),       base::RowOf(kMaxDepthMiss_px),
          base::RowOf(kLineHypotheses),     base::RowOf(kMaxLineDeviation),
          base::RowOf(kLineFitRounds),      base::RowOf(kMaxPixels),
          base::RowOf(kMinOctaveSide_px),   base::RowOf(kBaseBlur_px),
          base::RowOf(kPictureBlur_px),     base::RowOf(kKernelReach),
          base::RowOf(kExtremumBorder_px),  base::RowOf(kMoveBeyond_px),
          base::RowOf(kMaxMoves),           base::RowOf(kMaxCurvatureRatio),
          base::RowOf(kMinContrast),        base::RowOf(kRelativeContrast),
          base::RowOf(kGridCell_px),        base::RowOf(kCrowding),
          base::RowOf(kAngleWindow),        base::RowOf(kAngleWindowReach),
          base::RowOf(kAngleSmoothing_rad), base::RowOf(kSecondAngle),
          base::RowOf(kCellSize),           base::RowOf(kPatchCells),
          base::RowOf(kPatchWindow),        base::RowOf(kLargestShare)};
}

}  // namespace treeline::features
