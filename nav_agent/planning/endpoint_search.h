// Where a plan begins and ends if what was asked for has no room.
#ifndef NAV_AGENT_PLANNING_ENDPOINT_SEARCH_H_
#define NAV_AGENT_PLANNING_ENDPOINT_SEARCH_H_

#include <functional>
#include <optional>

#include "nav_agent/planning/configuration_space.h"
#include "nav_agent/planning/variable_rrt.h"

namespace treeline::planning {

struct MovedStand {
  Stand stand;
  double moved_m = 0;
};

// `wanted` if the robot fits there. Else the nearest place, at most max_move_m
// away, that a straight line leads to without crossing what is blocked once it
// has left it: with the same heading if there is one, else with the one that
// differs least. nullopt: there is none. Places for which `is_allowed` says
// no are left out.
std::optional<MovedStand> NearestStand(
    const ConfigurationSpace& space, const Stand& wanted, double max_move_m,
    const std::function<bool(const Spot&)>& is_allowed);

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_ENDPOINT_SEARCH_H_
