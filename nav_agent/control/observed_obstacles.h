// What stands in a local costmap, as things rather than cells.
#ifndef NAV_AGENT_CONTROL_OBSERVED_OBSTACLES_H_
#define NAV_AGENT_CONTROL_OBSERVED_OBSTACLES_H_

#include <cstdint>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/control/costmap_window.h"
#include "nav_agent/control/ground_layer.h"
#include "nav_agent/control/obstacle_layer.h"

namespace treeline::control {

// Seen obstacles that hang together.
struct ObservedObstacle {
  geometry::Vec2 center_in_map;
  // 0: there is none.
  double radius_m = 0;
  // For how long its youngest tenth has been there (s).
  double age_s = 1e6;
};

// A cell's centre.
struct RememberedObstacle {
  geometry::Vec2 in_map;
  // Seen, rather than the map's.
  bool is_new = false;
};

// The seen obstacle nearest to a point, if it is within reach_m: cells on the
// ground that count, gaps of a cell included. now_ms: as in ObstacleLayer.
ObservedObstacle ObservedObstacleNear(const CostmapWindow& window,
                                      const GroundLayer& ground,
                                      const ObstacleLayer& obstacles,
                                      geometry::Vec2 point_in_map,
                                      double reach_m, int64_t now_ms);

// Centres of the obstacles' cells within radius_m of a point that no sensor
// shows at this moment: the map's, where they border on ground, and seen ones
// that are only remembered.
std::vector<RememberedObstacle> UnseenObstaclesNear(
    const CostmapWindow& window, const GroundLayer& ground,
    const ObstacleLayer& obstacles, geometry::Vec2 at, double radius_m,
    int64_t now_ms);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_OBSERVED_OBSTACLES_H_
