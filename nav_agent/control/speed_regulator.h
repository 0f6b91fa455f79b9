// What regulators of the speed along a track are made of.
#ifndef NAV_AGENT_CONTROL_SPEED_REGULATOR_H_
#define NAV_AGENT_CONTROL_SPEED_REGULATOR_H_

#include <concepts>
#include <limits>

namespace treeline::control {

// A point of a track as regulators see it.
struct ProfilePoint {
  // The free distance of the footprint (m); negative: it touches something.
  double clearance_m = 1;
  // The ground's.
  double slope_rad = 0;
  // By how much the line's direction changes about the point, without sign
  // (rad), and that over the length it is measured over (1/m).
  double turn_rad = 0;
  double curvature_per_m = 0;
  // What speed zones allow there (m/s).
  double max_mps = std::numeric_limits<double>::infinity();
};

// Regulators are values: the speed (m/s) that the ones before allow at a point
// goes in, theirs comes out.
template <typename T>
concept SpeedRegulator = requires(const T& regulator, double speed_mps,
                                  const ProfilePoint& point) {
  { regulator.Regulated(speed_mps, point) } -> std::same_as<double>;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_SPEED_REGULATOR_H_
