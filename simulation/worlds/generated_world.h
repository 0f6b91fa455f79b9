// Any number of buildings, by seed.
#ifndef SIMULATION_WORLDS_GENERATED_WORLD_H_
#define SIMULATION_WORLDS_GENERATED_WORLD_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "simulation/building/building_plan.h"

namespace treeline::worlds {

// A robot of this radius gets to all places of a generated building, and along
// its tour.
inline constexpr double kGeneratedRobotRadius_m = 0.36;

// The building that `seed` stands for: drawn again, with the next attempt,
// until it is such a one. INTERNAL if 50 attempts are not enough.
absl::StatusOr<building::BuildingPlan> GeneratedPlan(uint64_t seed);

// Likewise an office building of that many square metres, in
// [building::kSmallestOffice_m2, building::kLargestOffice_m2], or
// INVALID_ARGUMENT.
absl::StatusOr<building::BuildingPlan> OfficePlan(int area_m2, uint64_t seed);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_GENERATED_WORLD_H_
