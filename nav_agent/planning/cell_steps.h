// From a cell to those around it.
#ifndef NAV_AGENT_PLANNING_CELL_STEPS_H_
#define NAV_AGENT_PLANNING_CELL_STEPS_H_

#include <array>

#include "nav_agent/core/occupancy_grid.h"

namespace treeline::planning {

// To the eight cells beside it, and a knight's moves: by angle, from 0 on.
inline constexpr std::array<core::CellIndex, 16> kCellSteps = {{{1, 0},
                                                                {2, 1},
                                                                {1, 1},
                                                                {1, 2},
                                                                {0, 1},
                                                                {-1, 2},
                                                                {-1, 1},
                                                                {-2, 1},
                                                                {-1, 0},
                                                                {-2, -1},
                                                                {-1, -1},
                                                                {-1, -2},
                                                                {0, -1},
                                                                {1, -2},
                                                                {1, -1},
                                                                {2, -1}}};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_CELL_STEPS_H_
