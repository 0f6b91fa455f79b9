#include "nav_agent/control/observed_obstacles.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>

namespace treeline::control {
namespace {

// Cells so far apart still hang together: gaps of a cell.
constexpr int kReach_cells = 2;

// Whether something was seen in a cell, and what is asked of it.
class SeenCells {
 public:
  SeenCells(const CostmapWindow& window, const GroundLayer& ground,
            const ObstacleLayer& obstacles)
      : window_(&window), ground_(&ground), obstacles_(&obstacles) {}

  bool Has(int x, int y) const {
    const size_t i = window_->IndexOf(x, y);
    return ground_->IsGround(i) && obstacles_->Counts(i);
  }

  std::optional<core::CellIndex> Nearest(geometry::Vec2 to,
                                         double reach_m) const {
    double best_m = reach_m;
    std::optional<core::CellIndex> nearest;
    for (int y = 0; y < window_->height(); ++y) {
      for (int x = 0; x < window_->width(); ++x) {
        if (!Has(x, y)) continue;
        const double away_m = geometry::Norm(window_->CenterInMap(x, y) - to);
        if (away_m < best_m) {
          best_m = away_m;
          nearest = core::CellIndex{x, y};
        }
      }
    }
    return nearest;
  }

  // What hangs together with a cell, itself first.
  std::vector<core::CellIndex> ClusterOf(core::CellIndex seed) const {
    std::vector<uint8_t> is_known(window_->cells(), 0);
    std::vector<core::CellIndex> cells = {seed};
    is_known[window_->IndexOf(seed.x, seed.y)] = 1;
    for (size_t next = 0; next < cells.size(); ++next) {
      const core::CellIndex at = cells[next];
      for (int y = at.y - kReach_cells; y <= at.y + kReach_cells; ++y) {
        for (int x = at.x - kReach_cells; x <= at.x + kReach_cells; ++x) {
          if (!window_->IsInside(x, y) || !Has(x, y) ||
              is_known[window_->IndexOf(x, y)] != 0) {
            continue;
          }
          is_known[window_->IndexOf(x, y)] = 1;
          cells.push_back({x, y});
        }
      }
    }
    return cells;
  }

 private:
  const CostmapWindow* window_;
  const GroundLayer* ground_;
  const ObstacleLayer* obstacles_;
};

}  // namespace

ObservedObstacle ObservedObstacleNear(const CostmapWindow& window,
                                      const GroundLayer& ground,
                                      const ObstacleLayer& obstacles,
                                      geometry::Vec2 point_in_map,
                                      double reach_m, int64_t now_ms) {
  ObservedObstacle obstacle;
  const SeenCells seen(window, ground, obstacles);
  const std::optional<core::CellIndex> nearest =
      seen.Nearest(point_in_map, reach_m);
  if (!nearest.has_value()) return obstacle;
  const std::vector<core::CellIndex> cells = seen.ClusterOf(*nearest);
  std::vector<int64_t> ages_ms;
  for (const core::CellIndex& cell : cells) {
    obstacle.center_in_map =
        obstacle.center_in_map + (1.0 / static_cast<double>(cells.size())) *
                                     window.CenterInMap(cell.x, cell.y);
    ages_ms.push_back(obstacles.Age_ms(window.IndexOf(cell.x, cell.y), now_ms));
  }
  for (const core::CellIndex& cell : cells) {
    obstacle.radius_m = std::max(
        obstacle.radius_m, geometry::Norm(window.CenterInMap(cell.x, cell.y) -
                                          obstacle.center_in_map) +
                               0.5 * window.resolution_m());
  }
  std::ranges::sort(ages_ms);
  obstacle.age_s = 0.001 * static_cast<double>(ages_ms[ages_ms.size() / 10]);
  return obstacle;
}

std::vector<RememberedObstacle> UnseenObstaclesNear(
    const CostmapWindow& window, const GroundLayer& ground,
    const ObstacleLayer& obstacles, geometry::Vec2 at, double radius_m,
    int64_t now_ms) {
  std::vector<RememberedObstacle> unseen;
  const core::CellIndex middle = window.CellOf(at);
  const int reach = static_cast<int>(radius_m / window.resolution_m()) + 1;
  for (int y = std::max(0, middle.y - reach);
       y <= std::min(window.height() - 1, middle.y + reach); ++y) {
    for (int x = std::max(0, middle.x - reach);
         x <= std::min(window.width() - 1, middle.x + reach); ++x) {
      const size_t i = window.IndexOf(x, y);
      const bool is_ground = ground.IsGround(i);
      if (is_ground && !obstacles.Counts(i)) continue;
      const geometry::Vec2 center = window.CenterInMap(x, y);
      if (geometry::Norm(center - at) > radius_m) continue;
      if (is_ground) {
        if (obstacles.IsSeenNow(i, now_ms)) continue;
        unseen.push_back(
            {.in_map = center, .is_new = obstacles.IsNew(i, ground)});
      } else if (ground.IsEdgeOfGround(window, x, y)) {
        unseen.push_back({.in_map = center});
      }
    }
  }
  return unseen;
}

}  // namespace treeline::control
