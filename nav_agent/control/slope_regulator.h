// Slower on slopes.
#ifndef NAV_AGENT_CONTROL_SLOPE_REGULATOR_H_
#define NAV_AGENT_CONTROL_SLOPE_REGULATOR_H_

#include <algorithm>

#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/speed_regulator.h"

namespace treeline::control {

// v loses kSlopeSlowing of itself on the steepest ground the robot may drive
// on, and less in proportion.
struct SlopeRegulator {
  double max_slope_rad = 1;

  double Regulated(double speed_mps, const ProfilePoint& point) const {
    return speed_mps *
           (1 - kSlopeSlowing *
                    std::clamp(point.slope_rad / max_slope_rad, 0.0, 1.0));
  }
};
static_assert(SpeedRegulator<SlopeRegulator>);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_SLOPE_REGULATOR_H_
