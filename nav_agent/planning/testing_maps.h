// Small maps drawn as text.
#ifndef NAV_AGENT_PLANNING_TESTING_MAPS_H_
#define NAV_AGENT_PLANNING_TESTING_MAPS_H_

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "nav_agent/traversability/navigation_map.h"

namespace treeline::planning {

// One level of flat ground. Rows from the top, each character a square of
// `scale` x `scale` cells of 0.05 m: '#' occupied, '?' unknown, else free.
inline traversability::TraversableLevel DrawnLevel(
    const std::vector<std::string>& rows, int scale, float height_m,
    const geometry::Rigid2& map_from_grid = {}) {
  const int height = scale * static_cast<int>(rows.size());
  const int width = scale * static_cast<int>(rows[0].size());
  traversability::TraversableLevel level;
  level.grid = core::OccupancyGrid::Filled(width, height, 0.05, map_from_grid,
                                           core::Occupancy::kFree);
  level.height_m.assign(level.grid.cells.size(), height_m);
  level.slope_rad.assign(level.grid.cells.size(), 0);
  level.clearance_m.assign(level.grid.cells.size(), 2.5F);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const char drawn = rows[static_cast<size_t>((height - 1 - y) / scale)]
                             [static_cast<size_t>(x / scale)];
      const size_t at = level.grid.IndexOf({x, y});
      if (drawn == '#') level.grid.cells[at] = core::Occupancy::kOccupied;
      if (drawn != '?') continue;
      level.grid.cells[at] = core::Occupancy::kUnknown;
      level.height_m[at] = std::numeric_limits<float>::quiet_NaN();
      level.slope_rad[at] = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return level;
}

inline std::shared_ptr<const traversability::NavigationMap> DrawnMap(
    const std::vector<std::string>& rows, int scale = 2,
    const geometry::Rigid2& map_from_grid = {},
    const traversability::NavigationMapOptions& options = {}) {
  traversability::TraversableMap map;
  map.levels.push_back(DrawnLevel(rows, scale, 0.0F, map_from_grid));
  return std::make_shared<const traversability::NavigationMap>(
      *traversability::NavigationMap::Make(std::move(map), options));
}

// A room of size_x x size_y m with walls of 0.1 m around it, in characters of
// 0.1 m.
inline std::vector<std::string> RoomRows(int size_x_dm, int size_y_dm) {
  std::vector<std::string> rows(
      static_cast<size_t>(size_y_dm),
      std::string(static_cast<size_t>(size_x_dm), '.'));
  rows.front().assign(static_cast<size_t>(size_x_dm), '#');
  rows.back() = rows.front();
  for (std::string& row : rows) {
    row.front() = '#';
    row.back() = '#';
  }
  return rows;
}

// Fills columns [x0, x1) and rows [y0, y1), counted from the bottom.
inline void Fill(std::vector<std::string>& rows, int x0, int x1, int y0, int y1,
                 char with) {
  const int height = static_cast<int>(rows.size());
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      rows[static_cast<size_t>(height - 1 - y)][static_cast<size_t>(x)] = with;
    }
  }
}

// A room of 8 x 5 m with a wall across, and a door of width_dm in it.
inline std::vector<std::string> TwoRoomsRows(int width_dm) {
  std::vector<std::string> rows = RoomRows(80, 50);
  Fill(rows, 40, 42, 1, 49, '#');
  Fill(rows, 40, 42, 20, 20 + width_dm, '.');
  return rows;
}

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_TESTING_MAPS_H_
