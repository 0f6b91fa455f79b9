#include "nav_agent/mapless/parameters.h"

namespace treeline::mapless {

std::vector<base::ParameterRow> MaplessParameters() {
  return {base::RowOf(kCell_m),        base::RowOf(kHitEvidence),
          base::RowOf(kMaxEvidence),   base::RowOf(kBodyMargin_m),
          base::RowOf(kSoftRoom_m),    base::RowOf(kNearCost),
          base::RowOf(kPresentWay),    base::RowOf(kWayWidth_m),
          base::RowOf(kReplan_s),      base::RowOf(kHorizon_s),
          base::RowOf(kFirstPart_s),   base::RowOf(kAhead_m),
          base::RowOf(kSlowest_mps),   base::RowOf(kSpeedOfRoom_ps),
          base::RowOf(kStuck_s),       base::RowOf(kBackOff_s),
          base::RowOf(kFittedScans),   base::RowOf(kMoverMemory_s),
          base::RowOf(kMoverSpread_m), base::RowOf(kMoverSpread_mps),
          base::RowOf(kTouchCost_mps), base::RowOf(kBlindCost)};
}

}  // namespace treeline::mapless
