// World files: buildings as YAML that people write.
// docs/reference/world-files.md is the language's description.
#ifndef SIMULATION_BUILDING_PLAN_FILE_H_
#define SIMULATION_BUILDING_PLAN_FILE_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "simulation/building/building_plan.h"

namespace treeline::building {

// INVALID_ARGUMENT, "FILE:LINE: reason", for what is not a building. Safe on
// any bytes. `name` is what errors call the file.
absl::StatusOr<BuildingPlan> ParsePlan(absl::string_view text,
                                       absl::string_view name);

// The plan as a world file; ParsePlan gives the same plan for it.
std::string PlanText(const BuildingPlan& plan);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_PLAN_FILE_H_
