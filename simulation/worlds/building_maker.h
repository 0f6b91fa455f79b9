// Makes worlds of buildings' plans.
#ifndef SIMULATION_WORLDS_BUILDING_MAKER_H_
#define SIMULATION_WORLDS_BUILDING_MAKER_H_

#include <string>

#include "absl/status/statusor.h"
#include "simulation/building/building_plan.h"
#include "simulation/worlds/world.h"

namespace treeline::worlds {

// INVALID_ARGUMENT for a plan that needs too many surfaces or textures. The
// plan must be one that ParsePlan would give.
absl::StatusOr<World> MakeBuilding(std::string name,
                                   const building::BuildingPlan& plan,
                                   const WorldOptions& options);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_BUILDING_MAKER_H_
