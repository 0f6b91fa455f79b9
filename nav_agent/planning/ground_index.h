// What planning asks of a map thousands of times for each plan.
#ifndef NAV_AGENT_PLANNING_GROUND_INDEX_H_
#define NAV_AGENT_PLANNING_GROUND_INDEX_H_

#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "nav_agent/traversability/navigation_map.h"
#include "nav_agent/zones/zone_map.h"

namespace treeline::planning {

// A place of a level, in the frame of the grids (m). All levels share it.
struct Spot {
  geometry::Vec2 at;
  int level = 0;

  constexpr bool operator==(const Spot&) const = default;
};

// A rectangle: from `origin`, in the direction (cos_yaw, sin_yaw), from back_m
// (below 0: behind) to front_m, and half_width_m to each side.
struct OrientedBox {
  geometry::Vec2 origin;
  double cos_yaw = 1;
  double sin_yaw = 0;
  double back_m = 0;
  double front_m = 0;
  double half_width_m = 0;
};

// Immutable and thread-safe; made once a map. A cell is blocked if
// NavigationMap's clearance there is 0, or it lies outside.
class GroundIndex {
 public:
  // zones: which way must not be driven; what is kept out of is blocked in
  // the map itself (NavigationMap of PlanGround). Null: any way may.
  explicit GroundIndex(std::shared_ptr<const traversability::NavigationMap> map,
                       std::shared_ptr<const zones::ZoneMap> zones = nullptr);

  const traversability::NavigationMap& map() const { return *map_; }
  bool has_one_way() const { return has_one_way_; }
  // As ZoneMap's; the heading in the grids' frame.
  bool ForbidsHeading(int level, core::CellIndex cell,
                      geometry::Vec2 heading) const {
    return has_one_way_ && zones_->ForbidsHeading(level, cell, heading);
  }
  int levels() const { return map_->levels(); }
  int width() const { return width_; }
  int height() const { return height_; }
  double resolution_m() const { return resolution_m_; }
  size_t cells() const {
    return static_cast<size_t>(width_) * static_cast<size_t>(height_);
  }

  core::CellIndex CellOf(geometry::Vec2 at) const;
  geometry::Vec2 CenterOf(core::CellIndex cell) const {
    return {(cell.x + 0.5) * resolution_m_, (cell.y + 0.5) * resolution_m_};
  }
  bool Contains(core::CellIndex cell) const {
    return cell.x >= 0 && cell.y >= 0 && cell.x < width_ && cell.y < height_;
  }
  size_t IndexOf(core::CellIndex cell) const {
    return static_cast<size_t>(cell.y) * static_cast<size_t>(width_) +
           static_cast<size_t>(cell.x);
  }

  // From the cell's centre to that of the nearest blocked one; 0 if blocked.
  double Clearance_m(int level, core::CellIndex cell) const {
    if (!Contains(cell)) return 0;
    return clearance_m_[static_cast<size_t>(level)][IndexOf(cell)];
  }
  // Of the ground's inclination, as a share of a right angle's: the sine.
  double SlopeSine(int level, core::CellIndex cell) const {
    if (!Contains(cell)) return 0;
    return slope_sine_[static_cast<size_t>(level)][IndexOf(cell)];
  }

  // Whether no blocked cell has area in common with the box. Exact.
  bool IsFree(int level, const OrientedBox& box) const {
    return IsClear(next_blocked_[static_cast<size_t>(level)], box);
  }
  // Whether the box has no ground that is another level's, continuing this
  // one's: who drives within it stays on the level.
  bool IsOfOneLevel(int level, const OrientedBox& box) const {
    return levels() == 1 ||
           IsClear(next_beyond_[static_cast<size_t>(level)], box);
  }
  // The same for a disc.
  bool IsFreeDisc(int level, geometry::Vec2 center, double radius_m) const;

  // The level that somebody on the ground of `cell` is on after a step to
  // `next`, a neighbour or the same: this one where it is free ground, or
  // another one whose free ground continues it; -1: there is none.
  int LevelAfter(int level, core::CellIndex cell, core::CellIndex next) const;

  // What Clearance_m is at least where a disc of radius_m might stand in the
  // cell: a point of a cell is at most half a diagonal from its centre, and a
  // blocked cell reaches half a side from its own.
  double NeededClearance_m(double radius_m) const {
    return radius_m - 0.5 * (std::numbers::sqrt2 - 1) * resolution_m_;
  }

 private:
  using NextInRow = std::vector<int32_t>;
  bool IsClear(const NextInRow& next, const OrientedBox& box) const;
  bool IsClearInRow(const NextInRow& next, int row, double from_x,
                    double to_x) const;

  std::shared_ptr<const traversability::NavigationMap> map_;
  std::shared_ptr<const zones::ZoneMap> zones_;
  bool has_one_way_;
  int width_;
  int height_;
  double resolution_m_;
  // One a level and cell.
  std::vector<std::vector<float>> clearance_m_;
  std::vector<std::vector<float>> slope_sine_;
  // The column of the first blocked cell from here on to the right; the width
  // where there is none.
  std::vector<NextInRow> next_blocked_;
  // The same of cells that are not blocked, nor free on this level.
  std::vector<NextInRow> next_beyond_;
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_GROUND_INDEX_H_
