// Things of a map that may be gone, and maps without them.
#ifndef NAV_AGENT_TRAVERSABILITY_LOOSE_THINGS_H_
#define NAV_AGENT_TRAVERSABILITY_LOOSE_THINGS_H_

#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::traversability {

// Cells of a level that are not free, that hang together, corners included, and
// that stand alone: no wall reaches to them.
struct LooseThing {
  int level = 0;
  std::vector<core::CellIndex> cells;
  // Of the ground all around, which is level: its surface (m).
  double ground_m = 0;
  // A circle about all cells (m).
  geometry::Vec2 middle_in_map;
  double radius_m = 0;
};

// All that are at most max_size_m along the grid's x and along its y. Not what
// has ground of several heights around it (kerbs, platforms, sides of ramps),
// reaches lower than that (holes), lies at the map's border, or is another
// level's ground.
std::vector<LooseThing> FindLooseThings(const NavigationMap& map,
                                        double max_size_m);

// Cells that were seen to be free ground although the map has something there.
// Immutable and thread-safe.
class FreedCells {
 public:
  struct Cell {
    int level = 0;
    core::CellIndex cell;
    // Of its surface (m).
    float ground_m = 0;
  };

  FreedCells() = default;
  explicit FreedCells(std::vector<Cell> cells);

  bool empty() const { return cells_.empty(); }
  std::span<const Cell> cells() const { return cells_; }
  // The ground there; nullopt: the cell is as the map has it.
  std::optional<float> Ground_m(int level, core::CellIndex cell) const;

 private:
  // By level, row and column.
  std::vector<Cell> cells_;
};

// The map with these cells free. INVALID_ARGUMENT: a cell is not on the map.
absl::StatusOr<NavigationMap> MapWithFreed(const NavigationMap& map,
                                           const FreedCells& freed);

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_LOOSE_THINGS_H_
