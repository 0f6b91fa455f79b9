// Buildings drawn by seed: a hall with a platform that a ramp and stairs go up
// to, one to three rooms beside it, furniture, posters, people.
#ifndef SIMULATION_BUILDING_PLAN_GENERATOR_H_
#define SIMULATION_BUILDING_PLAN_GENERATOR_H_

#include <cstdint>

#include "simulation/building/building_plan.h"

namespace treeline::building {

// A plan that a world file could hold. Nearly all are such that a robot gets
// everywhere; whoever needs that checks it, and draws the next attempt.
BuildingPlan DrawPlan(uint64_t seed, int attempt);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_PLAN_GENERATOR_H_
