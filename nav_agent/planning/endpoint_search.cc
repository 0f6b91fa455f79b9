#include "nav_agent/planning/endpoint_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {
namespace {

bool IsBlocked(const ConfigurationSpace& space, const Spot& spot) {
  const GroundIndex& ground = space.ground();
  const core::CellIndex cell = ground.CellOf(spot.at);
  if (!(ground.Clearance_m(spot.level, cell) > 0)) return true;
  return std::ranges::any_of(space.discs(), [&spot](const Disc& disc) {
    return disc.level == spot.level &&
           geometry::Norm(disc.center - spot.at) < disc.radius_m;
  });
}

// Whether the line, once it is on free ground, stays there.
bool LeadsToFreeSpace(const ConfigurationSpace& space, const Spot& from,
                      geometry::Vec2 to) {
  const geometry::Vec2 way = to - from.at;
  const int steps = std::max(
      1, static_cast<int>(std::ceil(geometry::Norm(way) /
                                    (0.5 * space.ground().resolution_m()))));
  bool is_out = false;
  for (int i = 0; i <= steps; ++i) {
    const geometry::Vec2 at = from.at + (static_cast<double>(i) / steps) * way;
    const bool is_blocked = IsBlocked(space, {at, from.level});
    if (is_out && is_blocked) return false;
    is_out = is_out || !is_blocked;
  }
  return true;
}

struct Candidate {
  Spot spot;
  double distance_m = 0;
};

std::vector<Candidate> CellsAround(const ConfigurationSpace& space,
                                   const Spot& middle, double reach_m) {
  const GroundIndex& ground = space.ground();
  const core::CellIndex cell = ground.CellOf(middle.at);
  const int reach = static_cast<int>(reach_m / ground.resolution_m()) + 1;
  std::vector<Candidate> cells;
  for (int y = cell.y - reach; y <= cell.y + reach; ++y) {
    for (int x = cell.x - reach; x <= cell.x + reach; ++x) {
      const geometry::Vec2 at = ground.CenterOf({x, y});
      const double distance_m = geometry::Norm(at - middle.at);
      if (distance_m > reach_m || !ground.Contains({x, y})) continue;
      cells.push_back({{at, middle.level}, distance_m});
    }
  }
  std::ranges::stable_sort(cells, {}, &Candidate::distance_m);
  return cells;
}

}  // namespace

std::optional<MovedStand> NearestStand(
    const ConfigurationSpace& space, const Stand& wanted, double max_move_m,
    const std::function<bool(const Spot&)>& is_allowed) {
  if (space.Fits(wanted.spot, wanted.yaw_rad) && is_allowed(wanted.spot)) {
    return MovedStand{.stand = wanted};
  }
  std::vector<Candidate> cells = CellsAround(space, wanted.spot, max_move_m);
  cells.insert(cells.begin(), {.spot = wanted.spot});
  for (int turn = 0; turn <= kEndHeadings; ++turn) {
    for (const Candidate& cell : cells) {
      if (!is_allowed(cell.spot)) continue;
      for (const int side : {1, -1}) {
        const double yaw_rad = geometry::NormalizedAngle_rad(
            wanted.yaw_rad + side * turn * std::numbers::pi / kEndHeadings);
        if (!space.Fits(cell.spot, yaw_rad) ||
            !LeadsToFreeSpace(space, wanted.spot, cell.spot.at)) {
          continue;
        }
        return MovedStand{.stand = {.spot = cell.spot, .yaw_rad = yaw_rad},
                          .moved_m = cell.distance_m};
      }
    }
  }
  return std::nullopt;
}

}  // namespace treeline::planning
