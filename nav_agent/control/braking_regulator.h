// In time for what comes.
#ifndef NAV_AGENT_CONTROL_BRAKING_REGULATOR_H_
#define NAV_AGENT_CONTROL_BRAKING_REGULATOR_H_

#include <algorithm>
#include <cmath>

namespace treeline::control {

// v^2 <= v_next^2 + 2 a s: from each point on the robot can brake for the next
// one. Unlike the other regulators of speed it looks at two points, from the
// end of the track backwards.
struct BrakingRegulator {
  // What is braked with (m/s^2).
  double deceleration_mps2 = 0;

  // The next point is distance_m ahead, and next_mps is the speed there.
  double Regulated(double speed_mps, double next_mps, double distance_m) const {
    return std::min(speed_mps, std::sqrt(next_mps * next_mps +
                                         2 * deceleration_mps2 * distance_m));
  }
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_BRAKING_REGULATOR_H_
