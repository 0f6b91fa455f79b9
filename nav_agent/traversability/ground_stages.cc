#include "nav_agent/traversability/ground_stages.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <utility>

namespace treeline::traversability {
namespace {

constexpr int kWordBits = 64;
// A gap lower than this many voxels is a voxel that was missed, within a wall.
constexpr int kMinGap = 4;
// Ground is seen if one of this many voxels above it was observed to be free.
constexpr int kSightReach = 4;
// A hole is closed if so many of its eight neighbours are ground at one
// height. Beside a straight edge they are three, in its inner corner five.
constexpr int kHoleSupport = 6;
// One in an edge has ground on both sides, and nobody has looked through it.
constexpr int kHoleSupportInEdge = 5;
// Next to walls fewer can be; walls count here.
constexpr int kHoleSupportAtWalls = 4;
constexpr int kHoleSupportWithWalls = 7;
constexpr int kSpikeSupport = 5;

bool BitAt(const uint64_t* words, int z) {
  return (words[z / kWordBits] >> (z % kWordBits) & 1) != 0;
}

// Sets in `spread` the bits of a column and of the voxels above and below.
void SpreadColumn(const uint64_t* column, int words, uint64_t* spread,
                  bool itself) {
  for (int w = 0; w < words; ++w) {
    uint64_t bits = column[w] << 1 | column[w] >> 1;
    if (itself) bits |= column[w];
    if (w > 0) bits |= column[w - 1] >> (kWordBits - 1);
    if (w + 1 < words) bits |= column[w + 1] << (kWordBits - 1);
    spread[w] |= bits;
  }
}

struct Hole {
  size_t column = 0;
  GroundNode node;
};

// What lies about height z in the columns around (x, y).
struct Surroundings {
  int support = 0;
  int outside = 0;       // of the map
  bool between = false;  // on two opposite sides
  int walls = 0;
  int seen = 0;
  std::array<int, 8> heights{};
};

Surroundings LookAround(const CleanColumns& columns,
                        const GroundColumns& ground, int x, int y, int z) {
  Surroundings around;
  std::array<bool, 8> is_ground{};
  for (size_t d = 0; d < kNeighbors.size(); ++d) {
    const int nx = x + kNeighbors[d].x;
    const int ny = y + kNeighbors[d].y;
    if (!ground.rect.Contains(nx, ny)) {
      ++around.outside;
      continue;
    }
    const auto column = ground.At(ground.ColumnOf(nx, ny));
    const auto near = std::find_if(
        column.begin(), column.end(),
        [z](const GroundNode& node) { return std::abs(node.z - z) <= 1; });
    if (near != column.end()) {
      is_ground[d] = true;
      around.heights[static_cast<size_t>(around.support++)] = near->z;
      if (near->seen) ++around.seen;
    } else if (columns.AnyOccupied(nx, ny, z + 2, z + 2 + kMinGap)) {
      ++around.walls;
    }
  }
  around.between =
      (is_ground[0] && is_ground[4]) || (is_ground[2] && is_ground[6]);
  return around;
}

bool HasGroundNear(std::span<const GroundNode> column, int z) {
  return std::any_of(column.begin(), column.end(), [z](const GroundNode& node) {
    return std::abs(node.z - z) <= 1;
  });
}

// The ground that closes column (x, y) at about height z, if it is to be
// closed.
bool CloseHole(const CleanColumns& columns, const GroundColumns& ground, int x,
               int y, int z, GroundNode& closed) {
  // Something stands here.
  if (columns.AnyOccupied(x, y, z + 1, z + 2 + kMinGap)) return false;
  Surroundings around = LookAround(columns, ground, x, y, z);
  // Nobody knows better of what lies outside.
  const int agreeing = around.support + around.outside;
  const bool close = agreeing >= kHoleSupport ||
                     (around.between && agreeing >= kHoleSupportInEdge &&
                      !columns.AnyFree(x, y, z - 2, z)) ||
                     (around.support >= kHoleSupportAtWalls &&
                      around.support + around.walls >= kHoleSupportWithWalls);
  if (!close) return false;
  const auto begin = around.heights.begin();
  std::nth_element(begin, begin + around.support / 2, begin + around.support);
  closed.z = around.heights[static_cast<size_t>(around.support / 2)];
  const int above = columns.NextOccupied(x, y, closed.z + 1);
  closed.clearance = above == kOpenAbove ? kOpenAbove : above - closed.z - 1;
  closed.seen = 2 * around.seen >= around.support;
  return closed.clearance >= kMinGap;
}

// `ground` with `holes`, which are in the order of columns.
GroundColumns WithHolesClosed(const GroundColumns& ground,
                              const std::vector<Hole>& holes) {
  GroundColumns closed;
  closed.rect = ground.rect;
  closed.begin.reserve(ground.begin.size());
  closed.nodes.reserve(ground.nodes.size() + holes.size());
  auto hole = holes.begin();
  for (size_t column = 0; column + 1 < ground.begin.size(); ++column) {
    const size_t begin = closed.nodes.size();
    const auto nodes = ground.At(column);
    closed.nodes.insert(closed.nodes.end(), nodes.begin(), nodes.end());
    for (; hole != holes.end() && hole->column == column; ++hole) {
      closed.nodes.push_back(hole->node);
    }
    std::sort(closed.nodes.begin() + static_cast<std::ptrdiff_t>(begin),
              closed.nodes.end(), [](const GroundNode& a, const GroundNode& b) {
                return a.z < b.z;
              });
    // What lies right below a hole that was closed was never to be stood on.
    for (size_t i = closed.nodes.size(); i-- > begin + 1;) {
      GroundNode& below = closed.nodes[i - 1];
      below.clearance =
          std::min(below.clearance, closed.nodes[i].z - below.z - 1);
      if (below.clearance < kMinGap) {
        closed.nodes.erase(closed.nodes.begin() +
                           static_cast<std::ptrdiff_t>(i - 1));
      }
    }
    closed.begin.push_back(static_cast<uint32_t>(closed.nodes.size()));
  }
  return closed;
}

}  // namespace

CleanColumns::CleanColumns(const octree::VoxelMap& voxels,
                           const ColumnRect& rect)
    : voxels_(voxels), rect_(rect), words_(voxels.words()) {
  const auto words = static_cast<size_t>(words_);
  occupied_.reserve(words * static_cast<size_t>(rect.width()) *
                    static_cast<size_t>(rect.height()));
  std::vector<uint64_t> near(words);
  for (int y = rect.begin_y; y < rect.end_y; ++y) {
    for (int x = rect.begin_x; x < rect.end_x; ++x) {
      const uint64_t* column = voxels.Occupied(x, y).data();
      std::fill(near.begin(), near.end(), 0);
      SpreadColumn(column, words_, near.data(), /*itself=*/false);
      for (const GridStep& step : kNeighbors) {
        const int nx = x + step.x;
        const int ny = y + step.y;
        if (nx < 0 || ny < 0 || nx >= voxels.size().x ||
            ny >= voxels.size().y) {
          continue;
        }
        SpreadColumn(voxels.Occupied(nx, ny).data(), words_, near.data(),
                     /*itself=*/true);
      }
      for (size_t w = 0; w < words; ++w) {
        occupied_.push_back(column[w] & near[w]);
      }
    }
  }
}

bool CleanColumns::IsOccupied(int x, int y, int z) const {
  return z >= 0 && z < voxels_.size().z && BitAt(Column(x, y), z);
}

bool CleanColumns::IsFree(int x, int y, int z) const {
  return voxels_.At({x, y, z}) == octree::Voxel::kFree;
}

bool CleanColumns::AnyFree(int x, int y, int begin_z, int end_z) const {
  for (int z = begin_z; z < end_z; ++z) {
    if (IsFree(x, y, z)) return true;
  }
  return false;
}

int CleanColumns::NextOccupied(int x, int y, int begin_z) const {
  const uint64_t* column = Column(x, y);
  begin_z = std::max(begin_z, 0);
  for (int w = begin_z / kWordBits; w < words_; ++w) {
    uint64_t bits = column[w];
    if (w == begin_z / kWordBits) bits &= ~uint64_t{0} << (begin_z % kWordBits);
    if (bits != 0) return w * kWordBits + std::countr_zero(bits);
  }
  return kOpenAbove;
}

int CleanColumns::NextNotOccupied(int x, int y, int begin_z) const {
  const uint64_t* column = Column(x, y);
  for (int w = begin_z / kWordBits; w < words_; ++w) {
    uint64_t bits = ~column[w];
    if (w == begin_z / kWordBits) bits &= ~uint64_t{0} << (begin_z % kWordBits);
    if (bits != 0) return w * kWordBits + std::countr_zero(bits);
  }
  return words_ * kWordBits;
}

GroundColumns FindTops(const CleanColumns& columns, bool needs_sight) {
  const ColumnRect& rect = columns.rect();
  GroundColumns ground;
  ground.rect = rect;
  const size_t count =
      static_cast<size_t>(rect.width()) * static_cast<size_t>(rect.height());
  ground.begin.reserve(count + 1);
  ground.nodes.reserve(count + count / 2);
  for (int y = rect.begin_y; y < rect.end_y; ++y) {
    for (int x = rect.begin_x; x < rect.end_x; ++x) {
      int z = columns.NextOccupied(x, y, 0);
      while (z < kOpenAbove) {
        const int end = columns.NextNotOccupied(x, y, z);
        const int next = columns.NextOccupied(x, y, end);
        const int clearance = next == kOpenAbove ? kOpenAbove : next - end;
        if (clearance >= kMinGap) {
          GroundNode node;
          node.z = end - 1;
          node.clearance = clearance;
          node.seen = !needs_sight ||
                      columns.AnyFree(x, y, end,
                                      end + std::min(clearance, kSightReach));
          ground.nodes.push_back(node);
        }
        z = next;
      }
      ground.begin.push_back(static_cast<uint32_t>(ground.nodes.size()));
    }
  }
  return ground;
}

GroundColumns FillHoles(const CleanColumns& columns, GroundColumns ground) {
  const ColumnRect& rect = ground.rect;
  std::vector<Hole> holes;
  for (int y = rect.begin_y; y < rect.end_y; ++y) {
    for (int x = rect.begin_x; x < rect.end_x; ++x) {
      const size_t column = ground.ColumnOf(x, y);
      // Four sides: a hole that is to be closed has ground on two at least.
      for (size_t side = 0; side < 8; side += 2) {
        const int nx = x + kNeighbors[side].x;
        const int ny = y + kNeighbors[side].y;
        if (!rect.Contains(nx, ny)) continue;
        for (const GroundNode& node : ground.At(ground.ColumnOf(nx, ny))) {
          if (HasGroundNear(ground.At(column), node.z)) continue;
          if (!holes.empty() && holes.back().column == column &&
              std::abs(holes.back().node.z - node.z) <= kMinGap) {
            continue;
          }
          Hole hole;
          hole.column = column;
          if (CloseHole(columns, ground, x, y, node.z, hole.node) &&
              !HasGroundNear(ground.At(column), hole.node.z)) {
            holes.push_back(hole);
          }
        }
      }
    }
  }
  return holes.empty() ? std::move(ground) : WithHolesClosed(ground, holes);
}

void LevelSpikes(GroundColumns& ground) {
  const ColumnRect& rect = ground.rect;
  std::vector<std::pair<size_t, int>> changes;
  for (int y = rect.begin_y; y < rect.end_y; ++y) {
    for (int x = rect.begin_x; x < rect.end_x; ++x) {
      const size_t column = ground.ColumnOf(x, y);
      for (size_t i = ground.begin[column]; i < ground.begin[column + 1]; ++i) {
        const int z = ground.nodes[i].z;
        int neighbors = 0;
        int lowest = z + 3;
        int highest = z - 3;
        for (const GridStep& step : kNeighbors) {
          if (!rect.Contains(x + step.x, y + step.y)) continue;
          for (const GroundNode& node :
               ground.At(ground.ColumnOf(x + step.x, y + step.y))) {
            if (std::abs(node.z - z) > 2) continue;
            ++neighbors;
            lowest = std::min(lowest, node.z);
            highest = std::max(highest, node.z);
            break;
          }
        }
        if (neighbors < kSpikeSupport) continue;
        if (highest == z - 1) changes.emplace_back(i, highest);
        if (lowest == z + 1) changes.emplace_back(i, lowest);
      }
    }
  }
  for (const auto& [i, z] : changes) {
    GroundNode& node = ground.nodes[i];
    if (node.clearance != kOpenAbove) node.clearance += node.z - z;
    node.z = z;
  }
}

}  // namespace treeline::traversability
