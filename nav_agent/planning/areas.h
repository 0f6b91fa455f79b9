// What is connected with what, for the narrowest part of a footprint.
#ifndef NAV_AGENT_PLANNING_AREAS_H_
#define NAV_AGENT_PLANNING_AREAS_H_

#include <cstdint>
#include <vector>

#include "nav_agent/planning/configuration_space.h"

namespace treeline::planning {

// Cells that the footprint's inscribed disc may stand in, in areas that are
// connected over levels. There is no way from one area to another; within one
// there need not be. Immutable.
class Areas {
 public:
  // Flood fill: linear in the cells.
  explicit Areas(const ConfigurationSpace& space);

  int count() const { return static_cast<int>(cells_.size()); }
  // From 0; -1 if the cell is in none.
  int Of(const GroundIndex& ground, const Spot& spot) const;
  // level * cells + cell, of each area.
  const std::vector<uint32_t>& CellsOf(int area) const {
    return cells_[static_cast<size_t>(area)];
  }

 private:
  // By level * cells + cell.
  std::vector<int32_t> areas_;
  std::vector<std::vector<uint32_t>> cells_;
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_AREAS_H_
