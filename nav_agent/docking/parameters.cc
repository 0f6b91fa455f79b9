#include "nav_agent/docking/parameters.h"

namespace treeline::docking {

std::vector<base::ParameterRow> DockingParameters() {
  return {base::RowOf(kTolerance_m),     base::RowOf(kTolerance_rad),
          base::RowOf(kAtDock_m),        base::RowOf(kAtDock_rad),
          base::RowOf(kPress_m),         base::RowOf(kStagingRoom_m),
          base::RowOf(kViewScans),       base::RowOf(kViewReach_m),
          base::RowOf(kViewTurn_rad),    base::RowOf(kViewResponse),
          base::RowOf(kInDockResponse),  base::RowOf(kViewStd_m),
          base::RowOf(kSeenFor_s),       base::RowOf(kBodyReach_m),
          base::RowOf(kBodyMoved_m),     base::RowOf(kDockSpeed_mps),
          base::RowOf(kTouchSpeed_mps),  base::RowOf(kSpeedOfWay_ps),
          base::RowOf(kTurnSpeed_radps), base::RowOf(kLinesInWay),
          base::RowOf(kMaxCurvature_pm), base::RowOf(kTries),
          base::RowOf(kPatience_s),      base::RowOf(kContact_s),
          base::RowOf(kIdle_s),          base::RowOf(kLow_s),
          base::RowOf(kRetry_s)};
}

}  // namespace treeline::docking
