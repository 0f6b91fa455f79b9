#include "nav_agent/traversability/levels.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "nav_agent/traversability/floors.h"

namespace treeline::traversability {
namespace {

// Levels are cut apart only for ground that lies above other ground on at
// least this area; less is a measuring error.
constexpr double kMinOverlapArea_m2 = 0.25;
// And on this much at each pair of heights.
constexpr double kMinPairArea_m2 = 0.05;
// Ground is looked for this far from a cell that has none, to tell walls from
// what is unknown.
constexpr double kWallReach_m = 0.5;

// ---- where levels are cut apart ----

// Heights of ground in one column that a robot could be at both.
struct Overlap {
  int upper = 0;
  int lower = 0;
  int64_t columns = 0;
};

// By the upper height.
std::vector<Overlap> FindOverlaps(const GroundColumns& ground,
                                  const NodeFacts& facts, int robot_height,
                                  double cell_m2) {
  std::map<std::pair<int, int>, int64_t> counts;
  for (size_t column = 0; column + 1 < ground.begin.size(); ++column) {
    if (ground.begin[column + 1] - ground.begin[column] < 2) continue;
    int lower = -1;
    for (uint32_t i = ground.begin[column]; i < ground.begin[column + 1]; ++i) {
      if (facts.floor[i] != kLargeFloor) continue;
      const GroundNode& node = ground.nodes[i];
      if (lower >= 0) ++counts[{node.z, lower}];
      lower = node.clearance >= robot_height ? node.z : -1;
    }
  }
  std::vector<Overlap> overlaps;
  overlaps.reserve(counts.size());
  for (const auto& [heights, columns] : counts) {
    if (static_cast<double>(columns) * cell_m2 < kMinPairArea_m2) continue;
    overlaps.push_back({heights.first, heights.second, columns});
  }
  return overlaps;
}

// The height in [low, high] with the least ground about it, so that both levels
// share some ramp there and no floor: the highest of those that have hardly
// more than the least.
int QuietestHeight(const std::map<int, int64_t>& ground_at, int low, int high,
                   int overlap) {
  int64_t least = std::numeric_limits<int64_t>::max();
  std::vector<int64_t> about;
  for (int z = low; z <= high; ++z) {
    int64_t here = 0;
    const auto end = ground_at.upper_bound(z + overlap);
    for (auto at = ground_at.lower_bound(z - overlap); at != end; ++at) {
      here += at->second;
    }
    about.push_back(here);
    least = std::min(least, here);
  }
  int cut = high;
  while (cut > low && about[static_cast<size_t>(cut - low)] > 2 * least) --cut;
  return cut;
}

// The fewest heights so that one lies in each overlap's (lower, upper], from
// the bottom up: the classic greedy stabbing. Of the heights that serve a
// cut's overlaps alike it takes QuietestHeight.
std::vector<int> FindCuts(const GroundColumns& ground, const NodeFacts& facts,
                          const std::vector<Overlap>& overlaps,
                          double resolution_m, int overlap) {
  const auto min_columns = static_cast<int64_t>(
      std::ceil(kMinOverlapArea_m2 / (resolution_m * resolution_m)));
  std::map<int, int64_t> ground_at;
  if (!overlaps.empty()) {
    for (size_t i = 0; i < ground.nodes.size(); ++i) {
      if (facts.floor[i] == kLargeFloor) ++ground_at[ground.nodes[i].z];
    }
  }
  std::vector<int> cuts;
  size_t i = 0;
  while (i < overlaps.size()) {
    // The lowest upper height with enough area up to it.
    const int last_cut = cuts.empty() ? -1 : cuts.back();
    int64_t columns = 0;
    int highest_lower = -1;
    size_t end = i;
    int upper = overlaps[i].upper;
    for (; end < overlaps.size(); ++end) {
      const Overlap& pair = overlaps[end];
      if (last_cut > pair.lower) continue;
      if (columns > 0 && pair.lower >= upper) break;
      if (columns == 0) upper = pair.upper;
      columns += pair.columns;
      highest_lower = std::max(highest_lower, pair.lower);
    }
    if (columns >= min_columns) {
      cuts.push_back(
          QuietestHeight(ground_at, highest_lower + 1, upper, overlap));
    }
    i = end;
  }
  return cuts;
}

// ---- levels ----

class LevelMaker {
 public:
  LevelMaker(const octree::VoxelMap& voxels, const GroundColumns& ground,
             const NodeFacts& facts, const VoxelLimits& limits)
      : voxels_(voxels), ground_(ground), facts_(facts), limits_(limits) {}

  // Of ground at heights [begin_z, end_z). `chosen` gets its node for each
  // cell.
  TraversableLevel Make(int begin_z, int end_z,
                        std::vector<uint32_t>& chosen) const {
    const int width = voxels_.size().x;
    const int height = voxels_.size().y;
    const double r = voxels_.resolution_m();
    TraversableLevel level;
    level.grid = core::OccupancyGrid::Filled(
        width, height, r,
        {.translation = {voxels_.lowest().x * r, voxels_.lowest().y * r},
         .yaw_rad = 0},
        core::Occupancy::kUnknown);
    const size_t cells = level.grid.cells.size();
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    level.height_m.assign(cells, kNan);
    level.slope_rad.assign(cells, kNan);
    level.clearance_m.assign(cells, kNan);
    chosen.resize(cells);
    for (size_t i = 0; i < cells; ++i) {
      chosen[i] = Choose(i, begin_z, end_z);
      if (chosen[i] != kNoNode) FillCell(i, chosen[i], level);
    }
    MarkWalls(chosen, level);
    CloseSeams(chosen, level);
    return level;
  }

 private:
  // The lowest floor that the robot fits on; else the lowest edge of one; else
  // the highest floor; else the lowest surface that was seen.
  uint32_t Choose(size_t column, int begin_z, int end_z) const {
    uint32_t best = kNoNode;
    int best_rank = 0;
    for (uint32_t i = ground_.begin[column]; i < ground_.begin[column + 1];
         ++i) {
      const GroundNode& node = ground_.nodes[i];
      if (node.z < begin_z || node.z >= end_z || !node.seen) continue;
      const bool has_room = node.clearance >= limits_.robot_height;
      if (facts_.floor[i] != 0 && has_room) return i;
      const int rank = facts_.rim[i] != 0 && has_room ? 3
                       : facts_.floor[i] != 0         ? 2
                                                      : 1;
      if (rank > best_rank || (rank == 2 && best_rank == 2)) {
        best = i;
        best_rank = rank;
      }
    }
    return best;
  }

  void FillCell(size_t cell, uint32_t i, TraversableLevel& level) const {
    const GroundNode& node = ground_.nodes[i];
    const double r = voxels_.resolution_m();
    const bool free =
        facts_.floor[i] != 0 && node.clearance >= limits_.robot_height;
    level.grid.cells[cell] =
        free ? core::Occupancy::kFree : core::Occupancy::kOccupied;
    level.height_m[cell] =
        static_cast<float>((voxels_.lowest().z + node.z + 0.5) * r);
    level.slope_rad[cell] = facts_.slope_rad[i];
    level.clearance_m[cell] = node.clearance == kOpenAbove
                                  ? std::numeric_limits<float>::infinity()
                                  : static_cast<float>(node.clearance * r);
  }

  // A cell without ground is occupied if something rises there from the floor
  // next to it, and unknown otherwise.
  void MarkWalls(const std::vector<uint32_t>& chosen,
                 TraversableLevel& level) const {
    const core::OccupancyGrid& grid = level.grid;
    std::vector<int> height(chosen.size(), -1);
    std::vector<size_t> front;
    for (size_t i = 0; i < chosen.size(); ++i) {
      if (chosen[i] == kNoNode || facts_.floor[chosen[i]] == 0) continue;
      height[i] = ground_.nodes[chosen[i]].z;
      front.push_back(i);
    }
    const int reach = static_cast<int>(kWallReach_m / voxels_.resolution_m());
    std::vector<size_t> next;
    for (int distance = 0; distance < reach; ++distance) {
      next.clear();
      for (const size_t i : front) {
        const auto width = static_cast<size_t>(grid.width);
        const core::CellIndex cell{static_cast<int>(i % width),
                                   static_cast<int>(i / width)};
        for (size_t d = 0; d < 8; d += 2) {
          const core::CellIndex to{cell.x + kNeighbors[d].x,
                                   cell.y + kNeighbors[d].y};
          if (!grid.Contains(to) || height[grid.IndexOf(to)] >= 0) continue;
          height[grid.IndexOf(to)] = height[i];
          next.push_back(grid.IndexOf(to));
          MarkWall(to, height[i], chosen, level);
        }
      }
      front.swap(next);
    }
  }

  // Where a level changes over from one ground to another above it, nothing
  // leads from cell to cell: the upper one's last cells are occupied.
  void CloseSeams(const std::vector<uint32_t>& chosen,
                  TraversableLevel& level) const {
    core::OccupancyGrid& grid = level.grid;
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        const size_t cell = grid.IndexOf({x, y});
        if (grid.cells[cell] != core::Occupancy::kFree) continue;
        const GroundNode& node = ground_.nodes[chosen[cell]];
        for (size_t d = 0; d < kNeighbors.size(); ++d) {
          const core::CellIndex to{x + kNeighbors[d].x, y + kNeighbors[d].y};
          if (!grid.Contains(to) || chosen[grid.IndexOf(to)] == kNoNode)
            continue;
          const size_t beyond = grid.IndexOf(to);
          if (facts_.floor[chosen[beyond]] == 0) continue;
          const int drop = node.z - ground_.nodes[chosen[beyond]].z;
          if (drop > limits_.step)
            grid.cells[cell] = core::Occupancy::kOccupied;
        }
      }
    }
  }

  void MarkWall(core::CellIndex cell, int floor_z,
                const std::vector<uint32_t>& chosen,
                TraversableLevel& level) const {
    if (chosen[level.grid.IndexOf(cell)] != kNoNode) return;
    for (int z = floor_z + limits_.step + 1;
         z <= floor_z + limits_.robot_height; ++z) {
      if (voxels_.At({cell.x, cell.y, z}) == octree::Voxel::kOccupied) {
        level.grid.Set(cell, core::Occupancy::kOccupied);
        return;
      }
    }
  }

  const octree::VoxelMap& voxels_;
  const GroundColumns& ground_;
  const NodeFacts& facts_;
  const VoxelLimits& limits_;
};

// The free cells that both levels have the same ground at, grouped where they
// touch.
std::vector<LevelJoin> FindJoins(const TraversableMap& map, int lower,
                                 const std::vector<uint32_t>& lower_chosen,
                                 const std::vector<uint32_t>& upper_chosen) {
  const core::OccupancyGrid& grid = map.levels[static_cast<size_t>(lower)].grid;
  std::vector<uint8_t> shared(lower_chosen.size());
  for (size_t i = 0; i < shared.size(); ++i) {
    shared[i] = lower_chosen[i] != kNoNode &&
                        lower_chosen[i] == upper_chosen[i] &&
                        grid.cells[i] == core::Occupancy::kFree
                    ? 1
                    : 0;
  }
  std::vector<LevelJoin> joins;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (shared[grid.IndexOf({x, y})] == 0) continue;
      LevelJoin join{
          .lower_level = lower, .upper_level = lower + 1, .cells = {{x, y}}};
      shared[grid.IndexOf({x, y})] = 0;
      for (size_t i = 0; i < join.cells.size(); ++i) {
        const core::CellIndex cell = join.cells[i];
        for (const GridStep& step : kNeighbors) {
          const core::CellIndex to{cell.x + step.x, cell.y + step.y};
          if (!grid.Contains(to) || shared[grid.IndexOf(to)] == 0) continue;
          shared[grid.IndexOf(to)] = 0;
          join.cells.push_back(to);
        }
      }
      joins.push_back(std::move(join));
    }
  }
  return joins;
}

}  // namespace

TraversableMap MakeLevels(const octree::VoxelMap& voxels,
                          const GroundColumns& ground,
                          const TraversabilityOptions& options) {
  const double r = voxels.resolution_m();
  const VoxelLimits limits(options, r);
  const NodeFacts facts = FindFacts(ground, options, r);
  std::vector<int> cuts = FindCuts(
      ground, facts, FindOverlaps(ground, facts, limits.robot_height, r * r), r,
      limits.overlap);
  const int top = voxels.size().z;
  const LevelMaker maker(voxels, ground, facts, limits);
  TraversableMap map;
  std::vector<uint32_t> chosen;
  std::vector<uint32_t> chosen_below;
  for (size_t level = 0; level <= cuts.size(); ++level) {
    const int begin = level == 0 ? 0 : cuts[level - 1] - limits.overlap;
    const int end = level == cuts.size() ? top : cuts[level] + limits.overlap;
    map.levels.push_back(maker.Make(begin, end, chosen));
    if (level > 0) {
      std::vector<LevelJoin> joins =
          FindJoins(map, static_cast<int>(level) - 1, chosen_below, chosen);
      map.joins.insert(map.joins.end(), std::make_move_iterator(joins.begin()),
                       std::make_move_iterator(joins.end()));
    }
    chosen_below.swap(chosen);
  }
  return map;
}

}  // namespace treeline::traversability
