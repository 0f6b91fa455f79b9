// The map that a robot makes while it drives: what its lasers see, cell by
// cell.
#ifndef NAV_AGENT_MAPLESS_EVIDENCE_GRID_H_
#define NAV_AGENT_MAPLESS_EVIDENCE_GRID_H_

#include <cstdint>
#include <span>
#include <vector>

#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/mapless/parameters.h"

namespace treeline::mapless {

// A beam that came back: from where it left to what it met, in the map.
struct GridBeam {
  geometry::Vec2 from;
  geometry::Vec2 to;
  // What it met moves, and is no part of the map.
  bool is_on_mover = false;
};

// Evidence by cell: beams that end there against beams that pass. What was
// never seen is unknown. It grows with what is seen, up to max_size_m a side;
// beyond that nothing is noted. Not thread-safe.
class EvidenceGrid {
 public:
  explicit EvidenceGrid(double cell_m = kCell_m, double max_size_m = 160);

  double cell_m() const { return cell_m_; }
  int width() const { return width_; }
  int height() const { return height_; }
  // The lower left corner of cell (0, 0) in the map.
  geometry::Vec2 origin() const { return origin_; }

  // The corners of what beams and marks ever reached; both the origin if none
  // did.
  geometry::Vec2 seen_low() const { return seen_low_; }
  geometry::Vec2 seen_high() const { return seen_high_; }

  // The beams of one scan: a cell in which one ends is not passed by others.
  void AddScan(std::span<const GridBeam> beams);
  // Something is known to stand there; beams that pass can say otherwise.
  void Mark(geometry::Vec2 point);
  void Clear();
  // What came into this circle less than `scans` scans ago has left it.
  void ForgetNew(geometry::Vec2 center, double radius_m, uint32_t scans);

  core::CellIndex CellOf(geometry::Vec2 point) const;
  geometry::Vec2 CenterOf(core::CellIndex cell) const;
  // What lies outside is unknown.
  core::Occupancy At(core::CellIndex cell) const;
  // Something has stood there for so many scans of late, or longer.
  bool HasStood(core::CellIndex cell, uint32_t scans) const;
  // A part: 1 where something stands, 0 elsewhere; rows from (x0, y0).
  std::vector<uint8_t> ObstaclesIn(int x0, int y0, int columns, int rows) const;
  // All of it, for pictures.
  core::OccupancyGrid Grid() const;

 private:
  static constexpr int8_t kUnseen = INT8_MIN;

  // False: that would be too large a map.
  bool MakeRoomFor(geometry::Vec2 low, geometry::Vec2 high);
  size_t IndexOf(core::CellIndex cell) const {
    return static_cast<size_t>(cell.y) * static_cast<size_t>(width_) +
           static_cast<size_t>(cell.x);
  }
  bool Contains(core::CellIndex cell) const {
    return cell.x >= 0 && cell.x < width_ && cell.y >= 0 && cell.y < height_;
  }
  void Pass(const GridBeam& beam);

  double cell_m_;
  int max_cells_;
  int width_ = 0;
  int height_ = 0;
  geometry::Vec2 origin_;
  geometry::Vec2 seen_low_;
  geometry::Vec2 seen_high_;
  std::vector<int8_t> evidence_;
  // The scan that touched a cell last.
  std::vector<uint32_t> touched_;
  // Since which scan something has stood there.
  std::vector<uint32_t> since_;
  uint32_t scan_ = 0;
  // Scans since the beginning.
  uint32_t scans_ = 0;
};

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_EVIDENCE_GRID_H_
