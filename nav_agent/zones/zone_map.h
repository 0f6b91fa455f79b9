// All zones of a map, cell by cell: what planning and control ask.
#ifndef NAV_AGENT_ZONES_ZONE_MAP_H_
#define NAV_AGENT_ZONES_ZONE_MAP_H_

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/traversability/traversability.h"
#include "nav_agent/zones/zone.h"
#include "nav_agent/zones/zone_masks.h"

namespace treeline::zones {

// Zones on the cells of the levels of a map. A cell is in a zone that its
// centre lies in, or that has a side through it: however narrow, a zone has
// cells. Where zones overlap all of them hold: out of a cell that one keeps out
// of, at the lowest of the speeds, and against none of the directions.
// Immutable and thread-safe.
class ZoneMap {
 public:
  // full_mps: what masks have percents of (m/s). INVALID_ARGUMENT: as
  // CheckZones; a zone that is beside the map; a mask of a level that there is
  // not; zones that leave nothing to drive on.
  static absl::StatusOr<std::shared_ptr<const ZoneMap>> Make(
      const traversability::TraversableMap& map, std::span<const Zone> zones,
      std::span<const ZoneMask> masks, double full_mps);

  bool empty() const { return !has_keep_out_ && !has_speed_ && !has_one_way_; }
  bool has_keep_out() const { return has_keep_out_; }
  bool has_one_way() const { return has_one_way_; }

  // False outside of the map.
  bool IsKeptOut(int level, core::CellIndex cell) const {
    return has_keep_out_ && Has(level, cell) &&
           LevelOf(level).keep_out[grid_.IndexOf(cell)] != 0;
  }
  bool IsKeptOut(int level, geometry::Vec2 point_in_map) const {
    return has_keep_out_ && IsKeptOut(level, grid_.CellOf(point_in_map));
  }
  // How far it is over free ground from a cell that is kept out of to the
  // nearest that is not, over cells and their diagonals (m); 0 where it is not
  // kept out, infinite where no way leads out.
  float WayOut_m(int level, core::CellIndex cell) const {
    return IsKeptOut(level, cell)
               ? LevelOf(level).way_out_m[grid_.IndexOf(cell)]
               : 0.0F;
  }
  // Infinite where there is no limit, and outside.
  double MaxSpeed_mps(int level, geometry::Vec2 point_in_map) const;
  // Whether a robot whose middle is in the cell must not drive ahead with a
  // heading, which is a unit vector in the frame of the grids: it has a
  // component against a direction of the cell's.
  bool ForbidsHeading(int level, core::CellIndex cell,
                      geometry::Vec2 heading_in_grid) const;

  // Of the cells that all of this is about, one a level.
  const core::OccupancyGrid& grid() const { return grid_; }
  // Of the zone or the mask that keeps out of a place; empty if none does.
  std::string KeepOutName(int level, geometry::Vec2 point_in_map) const;
  // Cells of all levels that are kept out of.
  int64_t kept_out_cells() const { return kept_out_cells_; }

 private:
  struct Level {
    // One a cell, each; empty if the level has none of that kind.
    std::vector<uint8_t> keep_out;
    std::vector<float> way_out_m;
    std::vector<float> max_mps;
    // Of direction_sets_; 0 is the empty one.
    std::vector<int32_t> directions;
  };

  explicit ZoneMap(const traversability::TraversableMap& map);

  bool Has(int level, core::CellIndex cell) const {
    return level >= 0 && static_cast<size_t>(level) < levels_.size() &&
           !LevelOf(level).keep_out.empty() && grid_.Contains(cell);
  }
  const Level& LevelOf(int level) const {
    return levels_[static_cast<size_t>(level)];
  }
  void AddDirections(std::span<const Zone> zones);
  void AddCells(const Zone& zone, const std::vector<size_t>& cells);
  void AddMask(const ZoneMask& mask, double full_mps);
  void MeasureWaysOut(const traversability::TraversableMap& map);

  // Without cells: where they lie.
  core::OccupancyGrid grid_;
  std::vector<Level> levels_;
  // Unit vectors in the frame of the grids.
  std::vector<std::vector<geometry::Vec2>> direction_sets_ = {{}};
  bool has_keep_out_ = false;
  bool has_speed_ = false;
  bool has_one_way_ = false;
  int64_t kept_out_cells_ = 0;
  // For names.
  std::vector<Zone> keep_out_zones_;
  std::vector<ZoneMask> keep_out_masks_;
};

// The cells of a zone, by their index in the grid, each once, in order.
std::vector<size_t> CellsOf(const Zone& zone, const core::OccupancyGrid& grid);

}  // namespace treeline::zones

#endif  // NAV_AGENT_ZONES_ZONE_MAP_H_
