// As fast as the robot can turn along the line.
#ifndef NAV_AGENT_CONTROL_CURVATURE_REGULATOR_H_
#define NAV_AGENT_CONTROL_CURVATURE_REGULATOR_H_

#include <algorithm>

#include "nav_agent/control/speed_regulator.h"

namespace treeline::control {

// v <= yaw rate / curvature.
struct CurvatureRegulator {
  // The fastest turn (rad/s).
  double max_yaw_rate_radps = 0;

  double Regulated(double speed_mps, const ProfilePoint& point) const {
    // Straighter than this the limit is beyond any speed.
    if (!(point.curvature_per_m > 1e-6)) return speed_mps;
    return std::min(speed_mps, max_yaw_rate_radps / point.curvature_per_m);
  }
};
static_assert(SpeedRegulator<CurvatureRegulator>);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_CURVATURE_REGULATOR_H_
