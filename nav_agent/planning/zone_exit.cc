#include "nav_agent/planning/zone_exit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "nav_agent/planning/cell_steps.h"
#include "nav_agent/planning/open_nodes.h"

namespace treeline::planning {
namespace {

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

uint32_t NumberOf(const GroundIndex& ground, const Spot& spot) {
  return static_cast<uint32_t>(static_cast<size_t>(spot.level) *
                                   ground.cells() +
                               ground.IndexOf(ground.CellOf(spot.at)));
}

Spot SpotOf(const GroundIndex& ground, uint32_t number) {
  const auto cell = static_cast<int>(number % ground.cells());
  return {.at = ground.CenterOf({cell % ground.width(), cell / ground.width()}),
          .level = static_cast<int>(number / ground.cells())};
}

// Marks the piece that a cell is in of what is kept out of on its level.
std::vector<uint8_t> PieceAt(const zones::ZoneMap& zones, int level,
                             core::CellIndex first) {
  const core::OccupancyGrid& grid = zones.grid();
  std::vector<uint8_t> piece(
      static_cast<size_t>(grid.width) * static_cast<size_t>(grid.height), 0);
  if (!zones.IsKeptOut(level, first)) return piece;
  std::vector<core::CellIndex> open = {first};
  piece[grid.IndexOf(first)] = 1;
  while (!open.empty()) {
    const core::CellIndex cell = open.back();
    open.pop_back();
    for (int k = 0; k < 9; ++k) {
      const core::CellIndex next = {cell.x + k % 3 - 1, cell.y + k / 3 - 1};
      if (!zones.IsKeptOut(level, next) || piece[grid.IndexOf(next)] != 0) {
        continue;
      }
      piece[grid.IndexOf(next)] = 1;
      open.push_back(next);
    }
  }
  return piece;
}

absl::StatusOr<traversability::NavigationMap> WithOccupied(
    const traversability::NavigationMap& map, const zones::ZoneMap& zones,
    int piece_level, const std::vector<uint8_t>& piece) {
  traversability::TraversableMap closed = map.traversable();
  for (int level = 0; level < map.levels(); ++level) {
    core::OccupancyGrid& grid = closed.levels[static_cast<size_t>(level)].grid;
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        const core::CellIndex cell = {x, y};
        if (!zones.IsKeptOut(level, cell)) continue;
        if (level == piece_level && piece[grid.IndexOf(cell)] != 0) continue;
        grid.Set(cell, core::Occupancy::kOccupied);
      }
    }
  }
  return traversability::NavigationMap::Make(std::move(closed), map.options());
}

}  // namespace

absl::StatusOr<traversability::NavigationMap> MapWithZones(
    const traversability::NavigationMap& map, const zones::ZoneMap& zones) {
  return WithOccupied(map, zones, -1, {});
}

absl::StatusOr<traversability::NavigationMap> MapWithoutZonesAt(
    const traversability::NavigationMap& map, const zones::ZoneMap& zones,
    const Spot& spot) {
  const double resolution_m = map.resolution_m();
  const core::CellIndex cell = {
      static_cast<int>(std::floor(spot.at.x / resolution_m)),
      static_cast<int>(std::floor(spot.at.y / resolution_m))};
  return WithOccupied(map, zones, spot.level, PieceAt(zones, spot.level, cell));
}

Polyline CellsOut(const ConfigurationSpace& inside,
                  const ConfigurationSpace& outside, const Spot& from,
                  const std::function<bool(const Spot&)>& is_good) {
  const GroundIndex& ground = inside.ground();
  if (!ground.Contains(ground.CellOf(from.at))) return {};
  const size_t all = ground.cells() * static_cast<size_t>(ground.levels());
  std::vector<float> way_m(all, std::numeric_limits<float>::infinity());
  std::vector<uint32_t> parent(all, kNone);
  OpenNodes open;
  const uint32_t first = NumberOf(ground, from);
  way_m[first] = 0;
  open.push({0, first});
  while (!open.empty()) {
    const OpenNode next = open.top();
    open.pop();
    if (next.estimate_m > way_m[next.number]) continue;
    const Spot spot = SpotOf(ground, next.number);
    if (outside.FitsTurning(spot) && is_good(spot)) {
      Polyline way;
      for (uint32_t at = next.number; at != first; at = parent[at]) {
        way.push_back(SpotOf(ground, at));
      }
      way.push_back(from);
      std::ranges::reverse(way);
      return way;
    }
    const core::CellIndex cell = ground.CellOf(spot.at);
    for (const core::CellIndex& step : kCellSteps) {
      if (std::abs(step.x) > 1 || std::abs(step.y) > 1) continue;
      const core::CellIndex beside = {cell.x + step.x, cell.y + step.y};
      const int level = ground.LevelAfter(spot.level, cell, beside);
      if (level < 0) continue;
      const Spot to = {.at = ground.CenterOf(beside), .level = level};
      if (!inside.MayHoldDisc(to)) continue;
      const auto cost_m =
          way_m[next.number] + static_cast<float>(ground.resolution_m() *
                                                  std::hypot(step.x, step.y) *
                                                  inside.CostPerMetre(to));
      const uint32_t number = NumberOf(ground, to);
      if (cost_m >= way_m[number]) continue;
      way_m[number] = cost_m;
      parent[number] = next.number;
      open.push({cost_m, number});
    }
  }
  return {};
}

bool LeadsWithOneWays(const ConfigurationSpace& space, const Spot& from,
                      const Spot& to) {
  const GroundIndex& ground = space.ground();
  std::vector<uint8_t> reached(
      ground.cells() * static_cast<size_t>(ground.levels()), 0);
  const uint32_t goal = NumberOf(ground, to);
  std::vector<uint32_t> open = {NumberOf(ground, from)};
  reached[open.front()] = 1;
  while (!open.empty()) {
    const uint32_t number = open.back();
    open.pop_back();
    if (number == goal) return true;
    const Spot spot = SpotOf(ground, number);
    const core::CellIndex cell = ground.CellOf(spot.at);
    for (const core::CellIndex& step : kCellSteps) {
      const double length = std::hypot(step.x, step.y);
      const geometry::Vec2 heading = {step.x / length, step.y / length};
      const core::CellIndex beside = {cell.x + step.x, cell.y + step.y};
      const int level = ground.LevelAfter(spot.level, cell, beside);
      if (level < 0 || ground.ForbidsHeading(spot.level, cell, heading) ||
          ground.ForbidsHeading(level, beside, heading)) {
        continue;
      }
      const Spot next = {.at = ground.CenterOf(beside), .level = level};
      const uint32_t next_number = NumberOf(ground, next);
      if (reached[next_number] != 0 || !space.MayHoldDisc(next)) continue;
      reached[next_number] = 1;
      open.push_back(next_number);
    }
  }
  return false;
}

}  // namespace treeline::planning
