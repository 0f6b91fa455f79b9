#include "nav_agent/planning/regions.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {
namespace {

constexpr int32_t kClosed = -1;
constexpr int32_t kOpen = -2;
constexpr uint8_t kUnknown = 0;
constexpr uint8_t kCan = 1;
constexpr uint8_t kCannot = 2;

core::CellIndex CellOfNumber(const GroundIndex& ground, uint32_t number) {
  const auto cell = static_cast<int>(number % ground.cells());
  return {cell % ground.width(), cell / ground.width()};
}

uint32_t NumberOf(const GroundIndex& ground, int level, core::CellIndex cell) {
  return static_cast<uint32_t>(static_cast<size_t>(level) * ground.cells() +
                               ground.IndexOf(cell));
}

Spot SpotOfNumber(const GroundIndex& ground, uint32_t number) {
  return {.at = ground.CenterOf(CellOfNumber(ground, number)),
          .level = static_cast<int>(number / ground.cells())};
}

// Whether a one-way zone forbids a step from a cell to one beside it.
bool IsAgainst(const GroundIndex& ground, const Spot& from, const Spot& to) {
  if (!ground.has_one_way()) return false;
  const geometry::Vec2 way = to.at - from.at;
  const double length_m = geometry::Norm(way);
  if (!(length_m > 0)) return false;
  const geometry::Vec2 heading = (1 / length_m) * way;
  return ground.ForbidsHeading(from.level, ground.CellOf(from.at), heading) ||
         ground.ForbidsHeading(to.level, ground.CellOf(to.at), heading);
}

}  // namespace

Regions::Regions(const ConfigurationSpace& space)
    : blocks_x_((space.ground().width() + kBlockCells - 1) / kBlockCells),
      blocks_y_((space.ground().height() + kBlockCells - 1) / kBlockCells),
      region_of_(
          space.ground().cells() * static_cast<size_t>(space.ground().levels()),
          kClosed),
      holds_(region_of_.size(), kUnknown),
      block_regions_(static_cast<size_t>(blocks_x_) *
                     static_cast<size_t>(blocks_y_) *
                     static_cast<size_t>(space.ground().levels())) {
  for (uint32_t block = 0; block < block_regions_.size(); ++block) {
    LabelBlock(space, block);
  }
  for (uint32_t region = 0; region < regions_.size(); ++region) {
    FindEdges(space, region);
  }
  for (uint32_t region = 0; region < regions_.size(); ++region) {
    JoinBack(region);
  }
  FindAreas();
}

Regions::Regions(const Regions& without, const ConfigurationSpace& space)
    : Regions(without) {
  const GroundIndex& ground = space.ground();
  std::vector<bool> is_changed(block_regions_.size(), false);
  std::vector<uint32_t> changed;
  for (const Disc& disc : space.discs()) {
    // Prices change further out; that only guides.
    const double reach_m = disc.radius_m + space.footprint().inscribed_m;
    const core::CellIndex low =
        ground.CellOf(disc.center - geometry::Vec2{reach_m, reach_m});
    const core::CellIndex high =
        ground.CellOf(disc.center + geometry::Vec2{reach_m, reach_m});
    if (disc.level < 0 || disc.level >= ground.levels()) continue;
    for (int y = std::max(0, low.y / kBlockCells);
         y <= std::min(blocks_y_ - 1, high.y / kBlockCells); ++y) {
      for (int x = std::max(0, low.x / kBlockCells);
           x <= std::min(blocks_x_ - 1, high.x / kBlockCells); ++x) {
        const uint32_t block =
            static_cast<uint32_t>((disc.level * blocks_y_ + y) * blocks_x_ + x);
        if (!is_changed[block]) changed.push_back(block);
        is_changed[block] = true;
      }
    }
  }
  // What touched the old regions has its edges made anew.
  std::vector<uint32_t> beside;
  for (const uint32_t block : changed) {
    for (const uint32_t region : block_regions_[block]) {
      for (const Edge& edge : edges_[region]) {
        if (!is_changed[regions_[edge.to].block]) beside.push_back(edge.to);
      }
      edges_[region].clear();
      regions_[region].cells = 0;
    }
    block_regions_[block].clear();
  }
  std::ranges::sort(beside);
  beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
  const auto first = static_cast<uint32_t>(regions_.size());
  for (const uint32_t block : changed) LabelBlock(space, block);
  for (const uint32_t region : beside) FindEdges(space, region);
  for (uint32_t region = first; region < regions_.size(); ++region) {
    FindEdges(space, region);
  }
  if (ground.levels() > 1) {
    for (uint32_t region = 0; region < regions_.size(); ++region) {
      JoinBack(region);
    }
  }
  FindAreas();
}

uint32_t Regions::BlockOf(int level, core::CellIndex cell) const {
  return static_cast<uint32_t>((level * blocks_y_ + cell.y / kBlockCells) *
                                   blocks_x_ +
                               cell.x / kBlockCells);
}

std::vector<uint32_t> Regions::CellsOfBlock(const GroundIndex& ground,
                                            uint32_t block) const {
  const int number = static_cast<int>(block);
  const int level = number / (blocks_x_ * blocks_y_);
  const int begin_x = kBlockCells * (number % blocks_x_);
  const int begin_y = kBlockCells * (number / blocks_x_ % blocks_y_);
  std::vector<uint32_t> cells;
  cells.reserve(size_t{kBlockCells} * kBlockCells);
  for (int y = begin_y; y < std::min(begin_y + kBlockCells, ground.height());
       ++y) {
    for (int x = begin_x; x < std::min(begin_x + kBlockCells, ground.width());
         ++x) {
      cells.push_back(NumberOf(ground, level, {x, y}));
    }
  }
  return cells;
}

void Regions::LabelBlock(const ConfigurationSpace& space, uint32_t block) {
  const GroundIndex& ground = space.ground();
  const std::vector<uint32_t> cells = CellsOfBlock(ground, block);
  for (const uint32_t cell : cells) {
    holds_[cell] = kUnknown;
    const Spot spot = SpotOfNumber(ground, cell);
    region_of_[cell] =
        ground.map().IsFree(spot.level, ground.CellOf(spot.at)) &&
                space.MayHoldDisc(spot)
            ? kOpen
            : kClosed;
  }
  for (const uint32_t first : cells) {
    if (region_of_[first] != kOpen) continue;
    const auto region = static_cast<int32_t>(regions_.size());
    std::vector<uint32_t> found = {first};
    region_of_[first] = region;
    geometry::Vec2 sum;
    const int level = static_cast<int>(first / ground.cells());
    for (size_t i = 0; i < found.size(); ++i) {
      const core::CellIndex from = CellOfNumber(ground, found[i]);
      sum = sum + ground.CenterOf(from);
      for (int k = 0; k < 9; ++k) {
        const core::CellIndex next = {from.x + k % 3 - 1, from.y + k / 3 - 1};
        if (!ground.Contains(next) || BlockOf(level, next) != block) {
          continue;
        }
        const uint32_t number = NumberOf(ground, level, next);
        if (region_of_[number] != kOpen) continue;
        region_of_[number] = region;
        found.push_back(number);
      }
    }
    regions_.push_back({.center = 1.0 / static_cast<double>(found.size()) * sum,
                        .level = level,
                        .area = 0,
                        .cells = static_cast<int>(found.size()),
                        .block = block});
    block_regions_[block].push_back(static_cast<uint32_t>(region));
  }
}

void Regions::FindEdges(const ConfigurationSpace& space, uint32_t region) {
  const GroundIndex& ground = space.ground();
  edges_.resize(regions_.size());
  edges_[region].clear();
  const int level = regions_[region].level;
  for (const uint32_t cell : CellsOfBlock(ground, regions_[region].block)) {
    if (region_of_[cell] != static_cast<int32_t>(region)) continue;
    const core::CellIndex from = CellOfNumber(ground, cell);
    const bool is_inside = from.x % kBlockCells % (kBlockCells - 1) != 0 &&
                           from.y % kBlockCells % (kBlockCells - 1) != 0;
    if (is_inside && ground.levels() == 1) continue;
    for (int k = 0; k < 9; ++k) {
      const core::CellIndex next = {from.x + k % 3 - 1, from.y + k / 3 - 1};
      const int to = ground.LevelAfter(level, from, next);
      if (to < 0) continue;
      const uint32_t number = NumberOf(ground, to, next);
      if (region_of_[number] < 0 || region_of_[number] == region_of_[cell]) {
        continue;
      }
      AddEdge(space, cell, number);
    }
  }
}

void Regions::AddEdge(const ConfigurationSpace& space, uint32_t from_cell,
                      uint32_t to_cell) {
  const auto from = static_cast<uint32_t>(region_of_[from_cell]);
  const auto to = static_cast<uint32_t>(region_of_[to_cell]);
  const Spot leaves = SpotOfNumber(space.ground(), from_cell);
  const Spot enters = SpotOfNumber(space.ground(), to_cell);
  const double length_m = geometry::Norm(leaves.at - regions_[from].center) +
                          geometry::Norm(enters.at - leaves.at) +
                          geometry::Norm(regions_[to].center - enters.at);
  const bool is_narrow =
      !HoldsFootprint(space, from_cell) || !HoldsFootprint(space, to_cell);
  const double narrow = is_narrow ? kNarrowCost.value : 1;
  const double price =
      narrow * (space.CostPerMetre(leaves) + space.CostPerMetre(enters)) / 2;
  const Edge edge = {.to = to,
                     .from_cell = from_cell,
                     .to_cell = to_cell,
                     .cost_m = static_cast<float>(price * length_m),
                     .length_m = static_cast<float>(length_m),
                     .short_m = static_cast<float>(narrow * length_m),
                     .is_against = IsAgainst(space.ground(), leaves, enters)};
  const auto known = std::ranges::find(edges_[from], to, &Edge::to);
  if (known == edges_[from].end()) {
    edges_[from].push_back(edge);
  } else if (std::pair{edge.is_against, edge.cost_m} <
             std::pair{known->is_against, known->cost_m}) {
    *known = edge;
  }
}

bool Regions::HoldsFootprint(const ConfigurationSpace& space, uint32_t cell) {
  uint8_t& known = holds_[cell];
  if (known == kUnknown) {
    const Spot spot = SpotOfNumber(space.ground(), cell);
    known = kCannot;
    for (int i = 0; i < kStandHeadings && known == kCannot; ++i) {
      if (space.Fits(spot, 2 * std::numbers::pi * i / kStandHeadings)) {
        known = kCan;
      }
    }
  }
  return known == kCan;
}

// Over levels, one region may see another that does not see it.
void Regions::JoinBack(uint32_t region) {
  for (const Edge& edge : edges_[region]) {
    std::vector<Edge>& back = edges_[edge.to];
    if (std::ranges::find(back, region, &Edge::to) != back.end()) continue;
    back.push_back({.to = region,
                    .from_cell = edge.to_cell,
                    .to_cell = edge.from_cell,
                    .cost_m = edge.cost_m,
                    .length_m = edge.length_m,
                    .short_m = edge.short_m,
                    .is_against = edge.is_against});
  }
}

void Regions::FindAreas() {
  area_cells_.clear();
  area_regions_.clear();
  area_sums_.clear();
  edges_.resize(regions_.size());
  for (Region& region : regions_) region.area = -1;
  for (uint32_t first = 0; first < regions_.size(); ++first) {
    if (regions_[first].area >= 0 || regions_[first].cells == 0) continue;
    const auto area = static_cast<int>(area_cells_.size());
    std::vector<uint32_t> found = {first};
    std::vector<uint32_t> sums;
    size_t cells = 0;
    regions_[first].area = area;
    for (size_t i = 0; i < found.size(); ++i) {
      cells += static_cast<size_t>(regions_[found[i]].cells);
      sums.push_back(static_cast<uint32_t>(cells));
      for (const Edge& edge : edges_[found[i]]) {
        if (regions_[edge.to].area >= 0) continue;
        regions_[edge.to].area = area;
        found.push_back(edge.to);
      }
    }
    area_cells_.push_back(cells);
    area_regions_.push_back(std::move(found));
    area_sums_.push_back(std::move(sums));
  }
}

int Regions::RegionOf(const GroundIndex& ground, const Spot& spot) const {
  const core::CellIndex cell = ground.CellOf(spot.at);
  if (!ground.Contains(cell)) return kClosed;
  return region_of_[NumberOf(ground, spot.level, cell)];
}

int Regions::AreaOf(const GroundIndex& ground, const Spot& spot) const {
  const int region = RegionOf(ground, spot);
  return region < 0 ? -1 : regions_[static_cast<size_t>(region)].area;
}

uint32_t Regions::DrawCell(const GroundIndex& ground, int area,
                           base::Random& random) const {
  const std::vector<uint32_t>& sums = area_sums_[static_cast<size_t>(area)];
  const uint32_t draw = random.NextBelow(sums.back());
  const auto after = std::ranges::upper_bound(sums, draw);
  const auto index = static_cast<size_t>(after - sums.begin());
  const uint32_t region = area_regions_[static_cast<size_t>(area)][index];
  uint32_t skip = draw - (index == 0 ? 0 : sums[index - 1]);
  for (const uint32_t cell : CellsOfBlock(ground, regions_[region].block)) {
    if (region_of_[cell] != static_cast<int32_t>(region)) continue;
    if (skip-- == 0) return cell;
  }
  return 0;  // not reached: a region has as many cells as it says
}

}  // namespace treeline::planning
