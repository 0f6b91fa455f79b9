// Out of a keep-out zone that a robot stands in, and whether one-way zones let
// it come to a place at all.
#ifndef NAV_AGENT_PLANNING_ZONE_EXIT_H_
#define NAV_AGENT_PLANNING_ZONE_EXIT_H_

#include <functional>
#include <memory>

#include "absl/status/statusor.h"
#include "nav_agent/planning/configuration_space.h"
#include "nav_agent/planning/plan_frame.h"
#include "nav_agent/planning/variable_rrt.h"
#include "nav_agent/zones/zone_map.h"

namespace treeline::planning {

// The map with everything that is kept out of occupied. INVALID_ARGUMENT: that
// leaves nothing.
absl::StatusOr<traversability::NavigationMap> MapWithZones(
    const traversability::NavigationMap& map, const zones::ZoneMap& zones);
// The same, but for what is kept out of in one piece with `spot`: there the map
// is as it is without zones.
absl::StatusOr<traversability::NavigationMap> MapWithoutZonesAt(
    const traversability::NavigationMap& map, const zones::ZoneMap& zones,
    const Spot& spot);

// The nearest place, over free ground of `inside` as wide as the footprint, at
// which the robot is out: it can turn there in `outside`, and `is_good` says
// yes. The cells' centres from `from` to there; empty if there is none.
Polyline CellsOut(const ConfigurationSpace& inside,
                  const ConfigurationSpace& outside, const Spot& from,
                  const std::function<bool(const Spot&)>& is_good);

// Whether steps in 16 directions, none of them against a one-way zone, lead
// over free ground as wide as the footprint from one place to another.
bool LeadsWithOneWays(const ConfigurationSpace& space, const Spot& from,
                      const Spot& to);

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_ZONE_EXIT_H_
