// The sections of a world's file that its structure is in: finishes, rooms, and
// what is built into them. Errors name file and line.
#ifndef SIMULATION_BUILDING_READ_STRUCTURE_H_
#define SIMULATION_BUILDING_READ_STRUCTURE_H_

#include "absl/status/status.h"
#include "common/yaml/yaml_node.h"
#include "simulation/building/building_plan.h"

namespace treeline::building {

// In the order in which they have to be read.
absl::Status ReadFinishes(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadRooms(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadPlatforms(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadRamps(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadStairs(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadWalls(const yaml::YamlNode& file, BuildingPlan& plan);
absl::Status ReadPillars(const yaml::YamlNode& file, BuildingPlan& plan);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_READ_STRUCTURE_H_
