// The crate that every world has for whoever wants to put something somewhere.
#ifndef SIMULATION_WORLDS_CRATE_H_
#define SIMULATION_WORLDS_CRATE_H_

#include <numbers>

#include "simulation/worlds/world.h"

namespace treeline::worlds {

inline constexpr char kCrate[] = "crate";

// The factors on its measures that make it so long along its own x and y (m);
// its height stays.
inline Float3 CrateScale(const World& world, double length_m, double width_m) {
  double side_m = 1;
  for (const Body& body : world.bodies) {
    // Of the circle that holds it.
    if (body.name == kCrate) {
      side_m = std::numbers::sqrt2 * static_cast<double>(body.radius_m);
    }
  }
  return {static_cast<float>(length_m / side_m),
          static_cast<float>(width_m / side_m), 1};
}

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_CRATE_H_
