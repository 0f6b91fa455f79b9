// No faster than a speed zone allows.
#ifndef NAV_AGENT_CONTROL_ZONE_REGULATOR_H_
#define NAV_AGENT_CONTROL_ZONE_REGULATOR_H_

#include <algorithm>

#include "nav_agent/control/speed_regulator.h"

namespace treeline::control {

// v is at most the lowest limit of the speed zones there.
struct ZoneRegulator {
  double Regulated(double speed_mps, const ProfilePoint& point) const {
    return std::min(speed_mps, point.max_mps);
  }
};
static_assert(SpeedRegulator<ZoneRegulator>);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_ZONE_REGULATOR_H_
