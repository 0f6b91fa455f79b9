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

// Pairs of poses that the robot and its margin fit at, in the largest area, all
// over the map.
std::vector<planning::PlanRequest> RequestsOn(
    const std::shared_ptr<const traversability::NavigationMap>& map, int count,
    uint64_t seed);

// The value that a share of all is below; 0 of none.
double Share(std::vector<double> values, double share);

}  // namespace treeline

#endif  // TESTS_TRAVERSABLE_WORLDS_PLANNER_MAPS_H_
