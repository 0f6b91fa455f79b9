// A map of one level: cells of ground that are free, occupied or unknown.
#ifndef NAV_AGENT_CORE_OCCUPANCY_GRID_H_
#define NAV_AGENT_CORE_OCCUPANCY_GRID_H_

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/geometry/rigid2.h"

namespace treeline::core {

// As in nav_msgs/OccupancyGrid, but for the type.
enum class Occupancy : uint8_t { kFree, kOccupied, kUnknown };

// Where a cell is: column x, row y.
struct CellIndex {
  int x = 0;
  int y = 0;

  constexpr bool operator==(const CellIndex&) const = default;
};

// Rows from the bottom: cell (0, 0) has its lower left corner at the origin of
// the grid's own frame, whose x runs along rows.
struct OccupancyGrid {
  int width = 0;
  int height = 0;
  double resolution_m = 0.05;
  // The grid's frame in the map.
  geometry::Rigid2 map_from_grid;
  std::vector<Occupancy> cells;

  static OccupancyGrid Filled(int width, int height, double resolution_m,
                              const geometry::Rigid2& map_from_grid,
                              Occupancy value) {
    return {
        .width = width,
        .height = height,
        .resolution_m = resolution_m,
        .map_from_grid = map_from_grid,
        .cells = std::vector<Occupancy>(
            static_cast<size_t>(width) * static_cast<size_t>(height), value)};
  }

  bool Contains(CellIndex cell) const {
    return cell.x >= 0 && cell.x < width && cell.y >= 0 && cell.y < height;
  }
  size_t IndexOf(CellIndex cell) const {
    return static_cast<size_t>(cell.y) * static_cast<size_t>(width) +
           static_cast<size_t>(cell.x);
  }
  Occupancy At(CellIndex cell) const { return cells[IndexOf(cell)]; }
  // What lies outside is unknown.
  Occupancy AtOrUnknown(CellIndex cell) const {
    return Contains(cell) ? At(cell) : Occupancy::kUnknown;
  }
  void Set(CellIndex cell, Occupancy value) { cells[IndexOf(cell)] = value; }

  // The cell that a point of the map lies in; it may be outside of the grid.
  CellIndex CellOf(geometry::Vec2 point_in_map) const {
    const geometry::Vec2 point = map_from_grid.Inverse() * point_in_map;
    return {static_cast<int>(std::floor(point.x / resolution_m)),
            static_cast<int>(std::floor(point.y / resolution_m))};
  }
  geometry::Vec2 CenterInMap(CellIndex cell) const {
    return map_from_grid * geometry::Vec2{(cell.x + 0.5) * resolution_m,
                                          (cell.y + 0.5) * resolution_m};
  }
};

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_OCCUPANCY_GRID_H_
