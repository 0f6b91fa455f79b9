// Slower beside obstacles.
#ifndef NAV_AGENT_CONTROL_CLEARANCE_REGULATOR_H_
#define NAV_AGENT_CONTROL_CLEARANCE_REGULATOR_H_

#include <algorithm>

#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/speed_regulator.h"

namespace treeline::control {

// v <= kSlowSpeed_mps + kNarrowGain_hz * room beside the footprint.
struct ClearanceRegulator {
  double Regulated(double speed_mps, const ProfilePoint& point) const {
    return std::min(
        speed_mps,
        kSlowSpeed_mps + kNarrowGain_hz * std::max(0.0, point.clearance_m));
  }
};
static_assert(SpeedRegulator<ClearanceRegulator>);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_CLEARANCE_REGULATOR_H_
