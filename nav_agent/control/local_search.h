// A way around what stands on a path, within sight.
#ifndef NAV_AGENT_CONTROL_LOCAL_SEARCH_H_
#define NAV_AGENT_CONTROL_LOCAL_SEARCH_H_

#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::control {

struct LocalSearchOptions {
  // Cells nearer to obstacles than this are closed (m, from centre to centre),
  // but for where the robot is already.
  double clearance_m = core::RobotModel().half_width_m + kManoeuvreRoom_m;
  // Cells nearer than this cost more, up to 1 + price times: where the band
  // would be pushed away (m).
  double desired_m = core::RobotModel().half_width_m + kInflation_m;
  double price = kRoomPrice;
  // The search stays this far from the window's edge (m).
  double inset_m = kTwoCells_m;
};

struct LocalWay {
  // From the start to one of the ends; empty if there is none.
  std::vector<geometry::Vec2> points_in_map;
  // Which end was reached.
  size_t end = 0;
};

// Dijkstra's algorithm on the costmap's cells from `start` to the end whose way
// is the cheapest, ends[i] at an extra cost of end_costs_m[i].
LocalWay FindLocalWay(const LocalCostmap& costmap, geometry::Vec2 start,
                      std::span<const geometry::Vec2> ends,
                      std::span<const double> end_costs_m,
                      const LocalSearchOptions& options);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_LOCAL_SEARCH_H_
