#include "nav_agent/traversability/floors.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "common/base/disjoint_sets.h"

namespace treeline::traversability {
namespace {

// The part of a surface's border that must be drops for it to be furniture.
constexpr double kDropShare = 0.25;

template <typename Function>
void ForEachNode(const GroundColumns& ground, const Function& function) {
  const ColumnRect& rect = ground.rect;
  for (int y = rect.begin_y; y < rect.end_y; ++y) {
    for (int x = rect.begin_x; x < rect.end_x; ++x) {
      const size_t column = ground.ColumnOf(x, y);
      for (uint32_t i = ground.begin[column]; i < ground.begin[column + 1];
           ++i) {
        function(x, y, i);
      }
    }
  }
}

// The node that `i` of column (x, y) is linked to in direction d.
uint32_t LinkedNode(const GroundColumns& ground, int x, int y, uint32_t i,
                    size_t d) {
  const uint8_t slot = ground.nodes[i].link[d];
  if (slot == kNoLink) return kNoNode;
  return ground
             .begin[ground.ColumnOf(x + kNeighbors[d].x, y + kNeighbors[d].y)] +
         slot;
}

double Slope_rad(const GroundNode& node, double resolution_m) {
  if (node.edge) return LayerGradient_rad(resolution_m, resolution_m, 0);
  // Layers are one voxel apart, so their edges lie 1 / gradient voxels apart.
  const double gradient = std::hypot(node.gradient_x, node.gradient_y);
  if (gradient == 0) return 0;
  return LayerGradient_rad(resolution_m, resolution_m, 1 / gradient);
}

// ---- which ground is part of a floor ----

// A connected patch of ground, named after its first node.
struct Patch {
  uint32_t nodes = 0;
  uint32_t border = 0;
  uint32_t drops = 0;  // edges of drops beside it
};

std::vector<Patch> MeasurePatches(const GroundColumns& ground,
                                  const NodeFacts& facts,
                                  base::DisjointSets& sets) {
  ForEachNode(ground, [&](int x, int y, uint32_t i) {
    if (facts.good[i] == 0) return;
    for (const size_t d : {size_t{0}, size_t{2}}) {
      const uint32_t other = LinkedNode(ground, x, y, i, d);
      if (other != kNoNode && facts.good[other] != 0) sets.Join(i, other);
    }
  });
  std::vector<Patch> patches(ground.nodes.size());
  ForEachNode(ground, [&](int x, int y, uint32_t i) {
    if (facts.good[i] != 0) {
      Patch& patch = patches[sets.Find(i)];
      ++patch.nodes;
      bool border = false;
      for (size_t d = 0; d < 8; d += 2) {
        const uint32_t other = LinkedNode(ground, x, y, i, d);
        border = border || other == kNoNode || facts.good[other] == 0;
      }
      if (border) ++patch.border;
    } else if (ground.nodes[i].edge) {
      for (size_t d = 0; d < 8; d += 2) {
        const uint32_t other = LinkedNode(ground, x, y, i, d);
        if (other == kNoNode || facts.good[other] == 0) continue;
        ++patches[sets.Find(other)].drops;
        break;
      }
    }
  });
  return patches;
}

// Treads of stairs are not longer (m).
constexpr double kMaxTread_m = 0.45;

constexpr int kNoTread = 1 << 20;

// Over how many nodes the narrow ground of (x, y) ends in a drop if one goes on
// in direction d: a tread does, and the corner of a floor does not.
int TreadLength(const GroundColumns& ground, int x, int y, uint32_t i, size_t d,
                int most) {
  for (int cells = 1; cells <= most; ++cells) {
    if (ground.nodes[i].edge) return cells;
    i = LinkedNode(ground, x, y, i, d);
    if (i == kNoNode || !ground.nodes[i].narrow) break;
    x += kNeighbors[d].x;
    y += kNeighbors[d].y;
  }
  return kNoTread;
}

// The length of the shortest tread next to (x, y) that leads up to height z.
int TreadBelow(const GroundColumns& ground, const VoxelLimits& limits, int x,
               int y, int z, int most) {
  int length = kNoTread;
  for (size_t d = 0; d < kNeighbors.size(); ++d) {
    const int nx = x + kNeighbors[d].x;
    const int ny = y + kNeighbors[d].y;
    if (!ground.rect.Contains(nx, ny)) continue;
    const size_t column = ground.ColumnOf(nx, ny);
    for (uint32_t i = ground.begin[column]; i < ground.begin[column + 1]; ++i) {
      const GroundNode& node = ground.nodes[i];
      const int rise = z - node.z;
      if (node.narrow && node.seen && rise > limits.step &&
          rise <= limits.riser) {
        length = std::min(length, TreadLength(ground, nx, ny, i, d, most));
      }
    }
  }
  return length;
}

// The edge of a floor that stairs lead up to.
struct StairHead {
  int x = 0;
  int y = 0;
  uint32_t node = 0;
  int tread = 0;  // cells

  bool IsNear(const StairHead& other) const {
    return std::max(std::abs(x - other.x), std::abs(y - other.y)) <= kHeadReach;
  }
  // One is noise: so many are needed within this of each other.
  static constexpr int kHeadReach = 5;
  static constexpr int kHeadSupport = 4;
};

std::vector<StairHead> FindStairHeads(const GroundColumns& ground,
                                      const VoxelLimits& limits,
                                      double resolution_m) {
  const int most = static_cast<int>(std::ceil(kMaxTread_m / resolution_m));
  std::vector<StairHead> found;
  ForEachNode(ground, [&](int x, int y, uint32_t i) {
    const GroundNode& node = ground.nodes[i];
    if (!node.edge || !node.seen) return;
    const int tread = TreadBelow(ground, limits, x, y, node.z, most);
    if (tread <= most) found.push_back({x, y, i, tread});
  });
  std::vector<StairHead> heads;
  for (const StairHead& head : found) {
    const auto support = std::count_if(
        found.begin(), found.end(),
        [&head](const StairHead& other) { return head.IsNear(other); });
    if (support > StairHead::kHeadSupport) heads.push_back(head);
  }
  return heads;
}

// The last tread of a flight lies level with the floor that it leads to, and
// looks like it. So floors are closed at the head of stairs, as far as the
// treads below are long and a cell more.
void CloseStairHeads(const GroundColumns& ground, const VoxelLimits& limits,
                     double resolution_m, std::vector<uint8_t>& floor) {
  const std::vector<StairHead> heads =
      FindStairHeads(ground, limits, resolution_m);
  int cells = 0;
  for (const StairHead& head : heads) cells = std::max(cells, head.tread);
  std::vector<StairHead> front;
  std::vector<StairHead> next;
  for (; cells > 0; --cells) {
    for (const StairHead& head : heads) {
      if (head.tread == cells) front.push_back(head);
    }
    next.clear();
    for (const StairHead& place : front) {
      for (size_t d = 0; d < kNeighbors.size(); ++d) {
        const uint32_t to = LinkedNode(ground, place.x, place.y, place.node, d);
        if (to == kNoNode || floor[to] == 0) continue;
        floor[to] = 0;
        next.push_back(
            {place.x + kNeighbors[d].x, place.y + kNeighbors[d].y, to, cells});
      }
    }
    front.swap(next);
  }
}

}  // namespace

NodeFacts FindFacts(const GroundColumns& ground,
                    const TraversabilityOptions& options, double resolution_m) {
  NodeFacts facts;
  facts.slope_rad.reserve(ground.nodes.size());
  facts.good.reserve(ground.nodes.size());
  for (const GroundNode& node : ground.nodes) {
    const double slope_rad = Slope_rad(node, resolution_m);
    facts.slope_rad.push_back(static_cast<float>(slope_rad));
    facts.good.push_back(!node.edge && !node.narrow && node.seen &&
                                 slope_rad < options.max_slope_rad
                             ? 1
                             : 0);
  }
  base::DisjointSets sets(ground.nodes.size());
  const std::vector<Patch> patches = MeasurePatches(ground, facts, sets);
  const auto is_large = [&](const Patch& patch) {
    return patch.nodes * resolution_m * resolution_m >=
           options.min_platform_area_m2;
  };
  // Heights of large floors, and those next to them.
  std::vector<uint8_t> has_floor;
  facts.floor.resize(ground.nodes.size());
  for (uint32_t i = 0; i < ground.nodes.size(); ++i) {
    if (facts.good[i] == 0 || !is_large(patches[sets.Find(i)])) continue;
    facts.floor[i] = kLargeFloor;
    const auto z = static_cast<size_t>(ground.nodes[i].z);
    if (has_floor.size() < z + 2) has_floor.resize(z + 2);
    has_floor[z + 1] = 1;
    has_floor[z] = 1;
    if (z > 0) has_floor[z - 1] = 1;
  }
  // Small patches are floor if they seem to be seen through a gap: at a large
  // one's height, and not ending in drops.
  for (uint32_t i = 0; i < ground.nodes.size(); ++i) {
    if (facts.good[i] == 0 || facts.floor[i] != 0) continue;
    const Patch& patch = patches[sets.Find(i)];
    const auto z = static_cast<size_t>(ground.nodes[i].z);
    const bool at_height =
        has_floor.empty() || (z < has_floor.size() && has_floor[z] != 0);
    facts.floor[i] =
        at_height && patch.drops < kDropShare * patch.border ? kSmallFloor : 0;
  }
  facts.rim.resize(ground.nodes.size());
  ForEachNode(ground, [&](int x, int y, uint32_t i) {
    if (!ground.nodes[i].edge || !ground.nodes[i].seen) return;
    for (size_t d = 0; d < kNeighbors.size(); ++d) {
      const uint32_t other = LinkedNode(ground, x, y, i, d);
      if (other != kNoNode && facts.floor[other] != 0) facts.rim[i] = 1;
    }
  });
  CloseStairHeads(ground, VoxelLimits(options, resolution_m), resolution_m,
                  facts.floor);
  return facts;
}

}  // namespace treeline::traversability
