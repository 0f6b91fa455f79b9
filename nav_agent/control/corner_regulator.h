// At a creep to where the robot will turn on the spot.
#ifndef NAV_AGENT_CONTROL_CORNER_REGULATOR_H_
#define NAV_AGENT_CONTROL_CORNER_REGULATOR_H_

#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/speed_regulator.h"

namespace treeline::control {

// v = kCreep_mps where the line turns by more than kTurnFrom_rad.
struct CornerRegulator {
  double Regulated(double speed_mps, const ProfilePoint& point) const {
    return point.turn_rad > kTurnFrom_rad ? kCreep_mps : speed_mps;
  }
};
static_assert(SpeedRegulator<CornerRegulator>);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_CORNER_REGULATOR_H_
