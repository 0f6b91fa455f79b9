// How far it is to the nearest obstacle, exactly.
#ifndef NAV_AGENT_CORE_DISTANCE_FIELD_H_
#define NAV_AGENT_CORE_DISTANCE_FIELD_H_

#include <cstdint>
#include <span>
#include <vector>

#include "nav_agent/core/occupancy_grid.h"

namespace treeline::core {

// Squared Euclidean distances, in cells, from the centre of each of width x
// height cells to that of the nearest one where `is_obstacle` is not 0; rows
// one after the other. kNoObstacle where there is none at all. Exact, in time
// linear in the cells: Felzenszwalb and Huttenlocher, "Distance Transforms of
// Sampled Functions", Theory of Computing 8 (2012), 415-428.
inline constexpr int32_t kNoObstacle = INT32_MAX;
std::vector<int32_t> SquaredDistances(int width, int height,
                                      std::span<const uint8_t> is_obstacle);

// Distances (m) from the centres of the cells of `grid` to that of the nearest
// occupied one, at most max_m; rows as in the grid.
std::vector<float> DistanceToOccupied(const OccupancyGrid& grid, double max_m);

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_DISTANCE_FIELD_H_
