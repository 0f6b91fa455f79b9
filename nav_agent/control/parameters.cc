#include "nav_agent/control/parameters.h"

#include <array>
#include <cstddef>
#include <string>

#include "absl/strings/str_join.h"
#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/manoeuvre_parameters.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/control/setting_parameters.h"

namespace treeline::control {
namespace {

template <size_t N>
base::ParameterRow ListRow(const base::Parameter<std::array<double, N>>& list) {
  return {list.name, absl::StrJoin(list.value, ", "), list.unit, list.origin,
          list.why};
}

std::vector<base::ParameterRow> Settings() {
  return {
      base::RowOf(kCostmapSize_m),
      base::RowOf(kCostmapResolution_m),
      base::RowOf(kMaxForward_mps),
      base::RowOf(kGoalTolerance_m),
      base::RowOf(kGoalToleranceAngle_rad),
      base::RowOf(kInflation_m),
      base::RowOf(kCycle_s),
      base::RowOf(kDepthRate_hz),
      base::RowOf(kStandingSpeed_mps),
      base::RowOf(kCorner_m),
  };
}

std::vector<base::ParameterRow> OfObstacles() {
  return {
      base::RowOf(kCellStep),
      base::RowOf(kStepVoxels),
      base::RowOf(kClimbVoxels),
      ListRow(kSeedHeights_m),
      base::RowOf(kGroundPerRange),
      base::RowOf(kZoneFootprintStep_m),
      base::RowOf(kZoneSlack_m),
      base::RowOf(kHitsToMark),
      base::RowOf(kMissWeight),
      base::RowOf(kNeighbourGap_m),
      base::RowOf(kBodyWidening_m),
      base::RowOf(kLegReach_m),
      base::RowOf(kPointReach_m),
      base::RowOf(kLookHeight_m),
      base::RowOf(kDepthRange_m),
      base::RowOf(kThingDepth_m),
      base::RowOf(kFloorScatter_m),
      base::RowOf(kDepthHoles_m),
      base::RowOf(kPoseJump_m),
      base::RowOf(kRecently_s),
      base::RowOf(kStandingAfter_s),
      base::RowOf(kStandingMemory_s),
      base::RowOf(kLegsApart_m),
      base::RowOf(kFittedScans),
      base::RowOf(kScansToBegin),
      base::RowOf(kScansToEnd),
      base::RowOf(kPositionUncertainty_mps),
      base::RowOf(kMaxWalkingSpeed_mps),
      base::RowOf(kPointMargin_m),
      base::RowOf(kLaserNoise_m),
      base::RowOf(kCellMargin_m),
      base::RowOf(kReaction_s),
      base::RowOf(kBrakingShare),
      base::RowOf(kYawBrakingShare),
      base::RowOf(kApproachSpeed_mps),
      base::RowOf(kBodyMargin_m),
      base::RowOf(kLostMargin_m),
      base::RowOf(kOutwardSpeed_mps),
      ListRow(kGuardShares),
      base::RowOf(kSweepStep_m),
      base::RowOf(kGuardSlack_m),
  };
}

std::vector<base::ParameterRow> OfDriving() {
  return {
      base::RowOf(kPathBack_m),        base::RowOf(kPathAhead_m),
      base::RowOf(kStoreyHeight_m),    base::RowOf(kHorizon_m),
      base::RowOf(kLostBand_m),        base::RowOf(kSkipCost),
      base::RowOf(kRepulsion),         base::RowOf(kBandGain),
      base::RowOf(kTurnWay),           base::RowOf(kBandIterations),
      base::RowOf(kGradientStep_m),    base::RowOf(kFlatGradient),
      base::RowOf(kOverlapShare),      base::RowOf(kRoomPrice),
      base::RowOf(kAccelerationShare), base::RowOf(kYawShare),
      base::RowOf(kLookAheadBase_m),   base::RowOf(kLookAheadTime_s),
      base::RowOf(kSlowSpeed_mps),     base::RowOf(kNarrowGain_hz),
      base::RowOf(kDirection_m),       base::RowOf(kSlopeSlowing),
      base::RowOf(kTurnFrom_rad),      base::RowOf(kTurnUntil_rad),
      base::RowOf(kTurnGain_hz),
  };
}

std::vector<base::ParameterRow> OfManoeuvres() {
  return {base::RowOf(kGoalNear_m),     base::RowOf(kContentShare),
          base::RowOf(kAbeamShare),     base::RowOf(kLeaveShare),
          base::RowOf(kAbeam_m),        base::RowOf(kAlignFrom_rad),
          base::RowOf(kAlignUntil_rad), base::RowOf(kGoalBrakeShare),
          base::RowOf(kGoalSpeed_mps),  base::RowOf(kBreak_s),
          base::RowOf(kPatience_s),     base::RowOf(kStuck_s),
          base::RowOf(kEscapeAhead_s),  base::RowOf(kEscapeLook_m),
          base::RowOf(kEscapeGain_rad), base::RowOf(kHeldCost_rad),
          base::RowOf(kRoomWorth),      base::RowOf(kRoomWorthMax_m),
          base::RowOf(kQuiet_s),        base::RowOf(kQuietMin_s),
          base::RowOf(kImpatience),     base::RowOf(kGotOn_m),
          ListRow(kRoundedAhead_s),     base::RowOf(kTurnParts)};
}

}  // namespace

std::vector<base::ParameterRow> ControlParameters() {
  std::vector<base::ParameterRow> rows;
  for (const std::vector<base::ParameterRow>& of_one :
       {Settings(), OfObstacles(), OfDriving(), OfManoeuvres()}) {
    rows.insert(rows.end(), of_one.begin(), of_one.end());
  }
  return rows;
}

}  // namespace treeline::control
