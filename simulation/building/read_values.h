// Parts of a world's file that occur in many places. Errors name file and line.
#ifndef SIMULATION_BUILDING_READ_VALUES_H_
#define SIMULATION_BUILDING_READ_VALUES_H_

#include <initializer_list>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/yaml/yaml_node.h"
#include "simulation/building/building_plan.h"

namespace treeline::building {

// How many of each thing a file may have, and how far things may be.
inline constexpr size_t kMaxThings = 500;
// A field of thin posts has many.
inline constexpr size_t kMaxPillars = 2000;
inline constexpr double kMaxSize_m = 200;

// The maps of the list `key`, each with no keys but the known ones.
absl::StatusOr<std::vector<yaml::YamlNode>> ReadList(
    const yaml::YamlNode& file, absl::string_view key,
    std::initializer_list<absl::string_view> known, size_t most = kMaxThings);

// A name of letters, digits, '-' and '_', at most 40.
absl::StatusOr<std::string> ReadName(const yaml::YamlNode& node);

// [x, y] or [x, y, z], within the building's size.
absl::StatusOr<PlanPoint> ReadPoint(const yaml::YamlNode& node,
                                    const BuildingPlan& plan);
absl::StatusOr<PlanPoint> ReadPointAt(const yaml::YamlNode& node,
                                      absl::string_view key,
                                      const BuildingPlan& plan);
// The same, where there is ground; otherwise an error.
absl::StatusOr<PlanPoint> ReadGroundPoint(const yaml::YamlNode& node,
                                          const BuildingPlan& plan);
// `at` and `facing`.
absl::StatusOr<PlanStand> ReadStand(const yaml::YamlNode& node,
                                    const BuildingPlan& plan);
// [x0, y0, x1, y1], at least 0.3 m each way and within the building's size.
absl::StatusOr<PlanArea> ReadArea(const yaml::YamlNode& node,
                                  const BuildingPlan& plan);
// A material or a finish of the file's.
absl::StatusOr<std::string> ReadFinish(const yaml::YamlNode& node,
                                       absl::string_view key,
                                       absl::string_view otherwise,
                                       const BuildingPlan& plan);
absl::Status CheckFinish(const yaml::YamlNode& node, absl::string_view finish,
                         const BuildingPlan& plan);
absl::StatusOr<PlanLamps> ReadLamps(const yaml::YamlNode& node);
// The direction in degrees, or as east, north, west, south.
absl::StatusOr<double> ReadFacing(const yaml::YamlNode& node,
                                  double otherwise_deg);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_READ_VALUES_H_
