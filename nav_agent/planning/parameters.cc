#include "nav_agent/planning/parameters.h"

#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {

std::vector<base::ParameterRow> PlanningParameters() {
  return {base::RowOf(kPlanMargin_m),       base::RowOf(kMaxIterations),
          base::RowOf(kComfort_m),          base::RowOf(kNearCost),
          base::RowOf(kComfortLength),      base::RowOf(kShortShare),
          base::RowOf(kSlopeCost),          base::RowOf(kTurnCost),
          base::RowOf(kTurnStep),           base::RowOf(kWayStep_m),
          base::RowOf(kEndHeadings),        base::RowOf(kLeavingWay),
          base::RowOf(kNarrowCost),         base::RowOf(kStandHeadings),
          base::RowOf(kRouteAttempts),      base::RowOf(kBridgedAttempts),
          base::RowOf(kStuckCost),          base::RowOf(kStuckReach_m),
          base::RowOf(kBridgeIterations),   base::RowOf(kBridgeSpread),
          base::RowOf(kBridgeNodes),        base::RowOf(kSamePlace_m),
          base::RowOf(kAlternativeCost),    base::RowOf(kSight_m),
          base::RowOf(kMaxStep_m),          base::RowOf(kLevelDistance_m),
          base::RowOf(kRootSteps),          base::RowOf(kGoalEvery),
          base::RowOf(kUnguidedIterations), base::RowOf(kAnywhereEvery),
          base::RowOf(kGuideSpacing_m),     base::RowOf(kEasyIterations),
          base::RowOf(kIdleAttempts),       base::RowOf(kMinGain_m),
          base::RowOf(kMinLine_m),          base::RowOf(kMoveEvery),
          base::RowOf(kShortcut_m),         base::RowOf(kMaxCut_m),
          base::RowOf(kIdleShare),          base::RowOf(kQuickAttempts),
          base::RowOf(kQuickExcess),        base::RowOf(kRestartIterations),
          base::RowOf(kIdleRestarts),       base::RowOf(kRestartGain),
          base::RowOf(kRestartTries),       base::RowOf(kPullAhead),
          base::RowOf(kPullSpacingMax_m),   base::RowOf(kGreed),
          base::RowOf(kLastLine_m),         base::RowOf(kLastTurn_rad),
          base::RowOf(kNicheNodes),         base::RowOf(kFloodAfter),
          base::RowOf(kOmplRange_m),        base::RowOf(kOmplShare),
          base::RowOf(kOmplLimit),          base::RowOf(kOmplAskEvery),
          base::RowOf(kStopEvery)};
}

}  // namespace treeline::planning
