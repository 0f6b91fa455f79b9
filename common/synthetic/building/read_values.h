// Parts of a world's file that occur in many places. Errors name file and line.
#ifndef COMMON_SYNTHETIC_BUILDING_READ_VALUES_H_
#define COMMON_SYNTHETIC_BUILDING_READ_VALUES_H_

#include <initializer_list>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/synthetic/building/building_plan.h"
#include "common/yaml/yaml_node.h"

namespace treeline {

// How many of each thing a file may have, and how far things may be.
inline constexpr size_t kMaxThings = 500;
inline constexpr double kMaxSize_m = 200;

// The maps of the list `key`, each with no keys but the known ones.
absl::StatusOr<std::vector<YamlNode>> ReadList(
    const YamlNode& file, absl::string_view key,
    std::initializer_list<absl::string_view> known);

// A name of letters, digits, '-' and '_', at most 40.
absl::StatusOr<std::string> ReadName(const YamlNode& node);

// [x, y] or [x, y, z], within the building's size.
absl::StatusOr<PlanPoint> ReadPoint(const YamlNode& node,
                                    const BuildingPlan& plan);
absl::StatusOr<PlanPoint> ReadPointAt(const YamlNode& node,
                                      absl::string_view key,
                                      const BuildingPlan& plan);
// The same, where there is ground; otherwise an error.
absl::StatusOr<PlanPoint> ReadGroundPoint(const YamlNode& node,
                                          const BuildingPlan& plan);
// `at` and `facing`.
absl::StatusOr<PlanStand> ReadStand(const YamlNode& node,
                                    const BuildingPlan& plan);
// [x0, y0, x1, y1], at least 0.3 m each way and within the building's size.
absl::StatusOr<PlanArea> ReadArea(const YamlNode& node,
                                  const BuildingPlan& plan);
// A material or a finish of the file's.
absl::StatusOr<std::string> ReadFinish(const YamlNode& node,
                                       absl::string_view key,
                                       absl::string_view otherwise,
                                       const BuildingPlan& plan);
absl::Status CheckFinish(const YamlNode& node, absl::string_view finish,
                         const BuildingPlan& plan);
absl::StatusOr<PlanLamps> ReadLamps(const YamlNode& node);
// The direction in degrees, or as east, north, west, south.
absl::StatusOr<double> ReadFacing(const YamlNode& node, double otherwise_deg);

// Sections of a file, in the order in which they have to be read.
absl::Status ReadFinishes(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadRooms(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadPlatforms(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadRamps(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadStairs(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadWalls(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadPillars(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadDoors(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadWindows(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadPosters(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadFurniture(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadMovers(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadPlaces(const YamlNode& file, BuildingPlan& plan);
absl::Status ReadTour(const YamlNode& file, BuildingPlan& plan);

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_BUILDING_READ_VALUES_H_
