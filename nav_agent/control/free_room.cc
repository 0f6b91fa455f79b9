#include "nav_agent/control/free_room.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/manoeuvre_parameters.h"
#include "nav_agent/control/obstacle_parameters.h"

namespace treeline::control {

bool CanTurnAt(const geometry::Rigid2& map_from_base,
               const LocalCostmap& costmap) {
  const double needed_m = std::min(
      kFreeRoom_m,
      costmap.FootprintDistance_m(map_from_base, kTwoCells_m) - kMaxApproach_m);
  for (int part = 0; part < kTurnParts; ++part) {
    geometry::Rigid2 turned = map_from_base;
    turned.yaw_rad += 2 * std::acos(-1.0) * part / kTurnParts;
    if (costmap.FootprintDistance_m(turned, kTwoCells_m) <= needed_m) {
      return false;
    }
  }
  return true;
}

double FreeWayAt_m(const geometry::Rigid2& map_from_base, double max_distance_m,
                   const LocalCostmap& costmap) {
  const double sign = max_distance_m < 0 ? -1 : 1;
  double free_m = 0;
  double room_m = costmap.FootprintDistance_m(map_from_base, kTwoCells_m);
  while (free_m < std::abs(max_distance_m)) {
    const double next_m =
        std::min(std::abs(max_distance_m), free_m + kSweepStep_m);
    geometry::Rigid2 moved = map_from_base;
    moved.translation = moved * geometry::Vec2{sign * next_m, 0};
    const double there_m = costmap.FootprintDistance_m(moved, kTwoCells_m);
    if (there_m <= std::min(kFreeRoom_m, room_m - kMaxApproach_m)) break;
    room_m = there_m;
    free_m = next_m;
  }
  return sign * free_m;
}

}  // namespace treeline::control
