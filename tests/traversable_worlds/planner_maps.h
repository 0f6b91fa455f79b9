// Maps to plan on that are larger, and of other kinds, than buildings.
#ifndef TESTS_TRAVERSABLE_WORLDS_PLANNER_MAPS_H_
#define TESTS_TRAVERSABLE_WORLDS_PLANNER_MAPS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nav_agent/planning/global_planner.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline {

// "city" (turned streets between blocks of buildings with yards), "maze",
// "rooms", "caves", and "cylinders" (posts of 7.5 cm radius, as in the BARN
// data set).
const std::vector<std::string>& PlannerMapKinds();

// One level of `size` x `size` cells of 0.05 m; a function of its arguments.
std::shared_ptr<const traversability::NavigationMap> MakePlannerMap(
    const std::string& kind, int size, uint64_t seed);

// Whether a kind names a file: it ends in .map or .yaml.
bool IsMapFile(const std::string& kind);

// A map of map_server, or one of the moving-AI benchmarks (Sturtevant,
// "Benchmarks for grid-based pathfinding", 2012: '.', 'G' and 'S' are free),
// with cells of 0.05 m. Ends the program, saying why, if it cannot be read.
std::shared_ptr<const traversability::NavigationMap> ReadPlannerMap(
    const std::string& path);

// Pairs of poses that the robot and its margin fit at, in the largest area, all
// over the map.
std::vector<planning::PlanRequest> RequestsOn(
    const std::shared_ptr<const traversability::NavigationMap>& map, int count,
    uint64_t seed);

// The value that a share of all is below; 0 of none.
double Share(std::vector<double> values, double share);

}  // namespace treeline

#endif  // TESTS_TRAVERSABLE_WORLDS_PLANNER_MAPS_H_
