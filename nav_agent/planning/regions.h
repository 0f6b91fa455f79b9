// What is connected with what, for the narrowest part of a footprint, and how
// far it is: a graph small enough to be searched in a millisecond or two.
#ifndef NAV_AGENT_PLANNING_REGIONS_H_
#define NAV_AGENT_PLANNING_REGIONS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/random.h"
#include "nav_agent/planning/configuration_space.h"

namespace treeline::planning {

// A map's cells lie in blocks of 8 x 8. Cells of one block and level that the
// footprint's inscribed disc may stand in, and that are connected within the
// block, are a region; regions whose cells touch are joined by an edge.
// Connected regions, over levels, are an area. There is no way from one area to
// another; within one there need not be, since a footprint has corners and
// zones may be one-way.
// Immutable and thread-safe.
class Regions {
 public:
  static constexpr int kBlockCells = 8;

  struct Region {
    // The mean of its cells.
    geometry::Vec2 center;
    int level = 0;
    int area = 0;
    int cells = 0;
    // Of all blocks of all levels.
    uint32_t block = 0;
  };
  // From one region to a neighbour, over two cells that touch (level * cells +
  // cell): those of the cheapest way from centre to centre.
  struct Edge {
    uint32_t to = 0;
    uint32_t from_cell = 0;
    uint32_t to_cell = 0;
    // Length times what a metre costs there, at least the length; more where
    // the footprint cannot stand in the middle of one of the cells, whatever
    // its heading: there the disc gets through, and the robot hardly.
    float cost_m = 0;
    float length_m = 0;
    // The length, and only for the footprint more.
    float short_m = 0;
    // Only against one-way zones; the cells and costs are as if there were
    // none.
    bool is_against = false;
  };

  // Linear in the cells.
  explicit Regions(const ConfigurationSpace& space);
  // Those of the same ground with the discs of `space` on it: only blocks that
  // the discs touch are looked at again. `without` has none.
  Regions(const Regions& without, const ConfigurationSpace& space);

  size_t count() const { return regions_.size(); }
  const Region& region(uint32_t number) const { return regions_[number]; }
  std::span<const Edge> EdgesOf(uint32_t number) const {
    return edges_[number];
  }
  // -1 if the spot's cell is in none.
  int RegionOf(const GroundIndex& ground, const Spot& spot) const;
  // By level * cells + cell.
  int RegionOfCell(uint32_t cell) const { return region_of_[cell]; }

  int areas() const { return static_cast<int>(area_cells_.size()); }
  // From 0; -1 if the cell is in none.
  int AreaOf(const GroundIndex& ground, const Spot& spot) const;
  size_t CellsOf(int area) const {
    return area_cells_[static_cast<size_t>(area)];
  }
  // A cell of the area, each as likely as any other: level * cells + cell.
  uint32_t DrawCell(const GroundIndex& ground, int area,
                    base::Random& random) const;

  // The cells of a block, as level * cells + cell, that lie on the map.
  std::vector<uint32_t> CellsOfBlock(const GroundIndex& ground,
                                     uint32_t block) const;
  size_t blocks() const { return block_regions_.size(); }

 private:
  void LabelBlock(const ConfigurationSpace& space, uint32_t block);
  void FindEdges(const ConfigurationSpace& space, uint32_t region);
  void AddEdge(const ConfigurationSpace& space, uint32_t from_cell,
               uint32_t to_cell);
  bool HoldsFootprint(const ConfigurationSpace& space, uint32_t cell);
  void JoinBack(uint32_t region);
  void FindAreas();
  uint32_t BlockOf(int level, core::CellIndex cell) const;

  int blocks_x_ = 0;
  int blocks_y_ = 0;
  std::vector<int32_t> region_of_;
  // What HoldsFootprint said of cells that it was asked of.
  std::vector<uint8_t> holds_;
  std::vector<Region> regions_;
  std::vector<std::vector<Edge>> edges_;
  // Of each block.
  std::vector<std::vector<uint32_t>> block_regions_;
  // Of each area: how many cells, its regions, and how many cells there are up
  // to each of them, itself included.
  std::vector<size_t> area_cells_;
  std::vector<std::vector<uint32_t>> area_regions_;
  std::vector<std::vector<uint32_t>> area_sums_;
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_REGIONS_H_
