#include "nav_agent/traversability/ramp_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace treeline::traversability {
namespace {

// A ramp of 1:24 has a step within it.
constexpr double kPlaneRadius_m = 1.3;
constexpr int kStepReach = 2;
// Sloped ground: steeper than floors of slightly tilted maps.
constexpr float kSloped_rad = 0.03F;
constexpr int kFewestPlaneCells = 20;
// Of other storeys is what is so many voxels higher or lower, and a step of so
// many is none of a ramp.
constexpr double kPlaneReach_cells = 3.5;
constexpr double kHighStep_cells = 1.5;
// Across the slope: more than 60 degrees from its direction; beside what is, 37
// degrees, where a step of the ramp meets its side.
constexpr double kAcross = 0.5;
constexpr double kAcrossBeside = 0.8;
// A floor whose voxels scatter has steps of one voxel everywhere, but is no
// higher, on the mean, on one side of them than on the other.
constexpr int kSideReach = 6;
constexpr double kLeastStep_cells = 0.6;
constexpr std::array<core::CellIndex, 4> kNeighbours = {
    {{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

class EdgeFinder {
 public:
  explicit EdgeFinder(const TraversableLevel& level)
      : level_(&level), grid_(&level.grid) {}

  // Whether the ground is higher behind the steps around than before them, and
  // they run across the slope.
  bool IsEdge(core::CellIndex cell) const {
    if (!IsStepBesideSlope(cell)) return false;
    const geometry::Vec2 step = StepDirection(cell, kStepReach);
    return StepHeight_cells(cell, step) >= kLeastStep_cells &&
           IsAcrossSlope(cell, step, kAcross);
  }
  // The same of what lies beside an edge: a single step.
  bool IsBesideEdge(core::CellIndex cell) const {
    return IsStepBesideSlope(cell) &&
           IsAcrossSlope(cell, StepDirection(cell, 0), kAcrossBeside);
  }

 private:
  bool IsStepBesideSlope(core::CellIndex cell) const {
    return IsGround(cell) && IsStepDown(cell) && HasSlopeNear(cell);
  }
  // Whether the cosine between the step and the slope is below `across`.
  bool IsAcrossSlope(core::CellIndex cell, geometry::Vec2 step,
                     double across) const {
    if (!(geometry::Norm(step) > 0)) return false;
    const std::optional<geometry::Vec2> uphill = Uphill(cell);
    return uphill.has_value() &&
           std::abs(geometry::Dot(step, *uphill)) <
               across * geometry::Norm(step) * geometry::Norm(*uphill);
  }

  // By how many voxels the ground behind a step is higher, on the mean, than
  // that before it.
  double StepHeight_cells(core::CellIndex middle, geometry::Vec2 step) const {
    const double length = geometry::Norm(step);
    if (!(length > 0)) return 0;
    std::array<double, 2> sum = {0, 0};
    std::array<int, 2> count = {0, 0};
    for (int y = -kSideReach; y <= kSideReach; ++y) {
      for (int x = -kSideReach; x <= kSideReach; ++x) {
        const core::CellIndex cell = {middle.x + x, middle.y + y};
        if (!IsGround(cell)) continue;
        const double rise = -DropTo(middle, cell);
        if (std::abs(rise) > kPlaneReach_cells) continue;
        // The middle is on the upper side, next to the step.
        const bool is_behind = (x * step.x + y * step.y) / length > -0.5;
        sum[is_behind ? 1 : 0] += rise;
        ++count[is_behind ? 1 : 0];
      }
    }
    if (count[0] == 0 || count[1] == 0) return 0;
    return sum[1] / count[1] - sum[0] / count[0];
  }

  bool IsGround(core::CellIndex cell) const {
    return grid_->Contains(cell) && grid_->At(cell) == core::Occupancy::kFree &&
           !std::isnan(level_->height_m[grid_->IndexOf(cell)]);
  }
  bool IsSloped(core::CellIndex cell) const {
    return IsGround(cell) &&
           level_->slope_rad[grid_->IndexOf(cell)] > kSloped_rad;
  }
  // By how many voxels `to` is lower; 0 if it is no ground.
  double DropTo(core::CellIndex from, core::CellIndex to) const {
    if (!IsGround(to)) return 0;
    return (level_->height_m[grid_->IndexOf(from)] -
            level_->height_m[grid_->IndexOf(to)]) /
           grid_->resolution_m;
  }
  bool IsStepDown(core::CellIndex cell) const {
    for (const core::CellIndex& way : kNeighbours) {
      const double drop = DropTo(cell, {cell.x + way.x, cell.y + way.y});
      if (drop > 0.5 && drop < kHighStep_cells) return true;
    }
    return false;
  }
  bool HasSlopeNear(core::CellIndex cell) const {
    for (int y = -kStepReach; y <= kStepReach; ++y) {
      for (int x = -kStepReach; x <= kStepReach; ++x) {
        if (IsSloped({cell.x + x, cell.y + y})) return true;
      }
    }
    return false;
  }

  // Whether the line between two cells stays on ground without high steps.
  bool IsInSight(core::CellIndex from, core::CellIndex to) const {
    const int steps =
        std::max(std::abs(to.x - from.x), std::abs(to.y - from.y));
    core::CellIndex at = from;
    for (int i = 1; i <= steps; ++i) {
      const double part = static_cast<double>(i) / steps;
      const core::CellIndex next = {
          from.x + static_cast<int>(std::lround(part * (to.x - from.x))),
          from.y + static_cast<int>(std::lround(part * (to.y - from.y)))};
      if (!IsGround(next) || std::abs(DropTo(at, next)) > kHighStep_cells) {
        return false;
      }
      at = next;
    }
    return true;
  }

  // The slope's direction where the ramp is on the higher side of a step, else
  // where it is on the lower one: its upper end, beside the floor it leads to.
  std::optional<geometry::Vec2> Uphill(core::CellIndex middle) const {
    const std::optional<geometry::Vec2> above =
        Uphill(middle, -0.5, kPlaneReach_cells);
    return above.has_value() ? above : Uphill(middle, -kPlaneReach_cells, -0.5);
  }

  // Of a plane through the sloped ground in sight between two heights over the
  // middle's (voxels), in the grid's axes; its length is the slope. What is
  // lower than a ramp's cell is the floor beside it, what is three voxels
  // higher is of other storeys, and what is out of sight of other ramps.
  std::optional<geometry::Vec2> Uphill(core::CellIndex middle, double lowest,
                                       double highest) const {
    const int reach = static_cast<int>(kPlaneRadius_m / grid_->resolution_m);
    const float middle_m = level_->height_m[grid_->IndexOf(middle)];
    double n = 0;
    geometry::Vec2 sum;
    double sum_h = 0;
    double xx = 0;
    double xy = 0;
    double yy = 0;
    double xh = 0;
    double yh = 0;
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const core::CellIndex cell = {middle.x + x, middle.y + y};
        if (x * x + y * y > reach * reach || !IsSloped(cell)) continue;
        const double h = (level_->height_m[grid_->IndexOf(cell)] - middle_m) /
                         grid_->resolution_m;
        if (h < lowest || h > highest || !IsInSight(middle, cell)) continue;
        n += 1;
        sum = sum +
              geometry::Vec2{static_cast<double>(x), static_cast<double>(y)};
        sum_h += h;
        xx += x * x;
        xy += x * y;
        yy += y * y;
        xh += x * h;
        yh += y * h;
      }
    }
    if (n < kFewestPlaneCells) return std::nullopt;
    xx -= sum.x * sum.x / n;
    xy -= sum.x * sum.y / n;
    yy -= sum.y * sum.y / n;
    xh -= sum.x * sum_h / n;
    yh -= sum.y * sum_h / n;
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 1e-6 * xx * yy)) return std::nullopt;
    const geometry::Vec2 uphill = {(yy * xh - xy * yh) / determinant,
                                   (xx * yh - xy * xh) / determinant};
    if (!(geometry::Norm(uphill) > kSloped_rad)) return std::nullopt;
    return uphill;
  }

  // The mean direction, upwards, of the steps around.
  geometry::Vec2 StepDirection(core::CellIndex middle, int reach) const {
    geometry::Vec2 sum;
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const core::CellIndex cell = {middle.x + x, middle.y + y};
        if (!IsGround(cell)) continue;
        for (const core::CellIndex& way : kNeighbours) {
          const double drop = DropTo(cell, {cell.x + way.x, cell.y + way.y});
          if (drop < 0.5) continue;
          sum = sum - geometry::Vec2{static_cast<double>(way.x),
                                     static_cast<double>(way.y)};
        }
      }
    }
    return sum;
  }

  const TraversableLevel* level_;
  const core::OccupancyGrid* grid_;
};

}  // namespace

std::vector<uint8_t> RampSideEdges(const TraversableLevel& level) {
  const core::OccupancyGrid& grid = level.grid;
  const EdgeFinder finder(level);
  std::vector<uint8_t> edges(grid.cells.size(), 0);
  std::vector<core::CellIndex> found;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (!finder.IsEdge({x, y})) continue;
      edges[grid.IndexOf({x, y})] = 1;
      found.push_back({x, y});
    }
  }
  for (const core::CellIndex& edge : found) {
    for (int y = edge.y - kStepReach; y <= edge.y + kStepReach; ++y) {
      for (int x = edge.x - kStepReach; x <= edge.x + kStepReach; ++x) {
        if (!grid.Contains({x, y}) || edges[grid.IndexOf({x, y})] != 0) {
          continue;
        }
        if (finder.IsBesideEdge({x, y})) {
          edges[grid.IndexOf({x, y})] = 1;
        }
      }
    }
  }
  return edges;
}

}  // namespace treeline::traversability
