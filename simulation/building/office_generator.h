// Office buildings of any size, for what grows with the place: wings of rooms
// on both sides of a corridor, side by side, and a corridor across that joins
// them. Some neighbouring rooms are furnished exactly alike.
#ifndef SIMULATION_BUILDING_OFFICE_GENERATOR_H_
#define SIMULATION_BUILDING_OFFICE_GENERATOR_H_

#include <cstdint>

#include "simulation/building/building_plan.h"

namespace treeline::building {

// Ground (m2). Below there is no room for rooms, above for what a world file
// may hold.
inline constexpr int kSmallestOffice_m2 = 100;
inline constexpr int kLargestOffice_m2 = 1500;

// A plan that a world file could hold, of `area_m2` within the bounds above to
// a hundredth; size and seed decide. Nearly all are such that a robot gets
// everywhere; whoever needs that checks it, and draws the next attempt.
BuildingPlan DrawOffice(int area_m2, uint64_t seed, int attempt);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_OFFICE_GENERATOR_H_
