// The sections of a world's file that follow its structure (read_structure.h):
// what is on walls and on floors, and what moves. Errors name file and line.
#ifndef SIMULATION_BUILDING_READ_THINGS_H_
#define SIMULATION_BUILDING_READ_THINGS_H_

#include "absl/status/status.h"
#include "common/yaml/yaml_node.h"
#include "simulation/building/building_plan.h"

namespace treeline::building {

// In the order in which they have to be read.
absl::Status ReadDoors(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadWindows(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadPosters(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadFurniture(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadMovers(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadPlaces(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadTour(const yaml::YamlNode& file, BuildingPlan& plan);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_READ_THINGS_H_
