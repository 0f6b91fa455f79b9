#include "nav_agent/traversability/rough_ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace treeline::traversability {
namespace {

// Roughness is measured in tiles of so many columns a side, whose borders are
// those of the map, and with the tiles around.
constexpr int kTile = 4;
// Mean height by which tops stand out, and lack (voxels): clean maps with 5 %
// of their voxels missing have less than 0.02.
constexpr float kRough = 0.06F;
// Tops that differ by more are of other surfaces (voxels).
constexpr int kScatter = 4;
constexpr int kMedianReach = 2;
constexpr int kMeanReach = 3;
constexpr int kMeanScatter = 1;

static_assert(2 * kTile - 1 + 1 + kMedianReach + kMeanReach < kSettleReach + 1,
              "what a height depends on");

// The top of a column that is nearest to a height, at most `reach` from it;
// nullptr: none.
const GroundNode* TopNear(const GroundColumns& ground, int x, int y, int z,
                          int reach) {
  if (!ground.rect.Contains(x, y)) return nullptr;
  const GroundNode* nearest = nullptr;
  int distance = reach + 1;
  for (const GroundNode& node : ground.At(ground.ColumnOf(x, y))) {
    if (std::abs(node.z - z) >= distance) continue;
    distance = std::abs(node.z - z);
    nearest = &node;
  }
  return nearest;
}

// How far a top stands out of the median of itself and its four neighbours, or
// (below 0) lacks in it; 0 beside where ground ends.
int Deviation(const GroundColumns& ground, int x, int y, int z) {
  std::array<int, 5> heights = {z};
  for (size_t d = 0; d < kNeighbors.size(); d += 2) {
    const GroundNode* near =
        TopNear(ground, x + kNeighbors[d].x, y + kNeighbors[d].y, z, kScatter);
    if (near == nullptr) return 0;
    heights[1 + d / 2] = near->z;
  }
  std::nth_element(heights.begin(), heights.begin() + 2, heights.end());
  return z - heights[2];
}

// Tiles of the map that a rectangle touches, and whether their ground scatters.
class Tiles {
 public:
  explicit Tiles(const GroundColumns& ground)
      : begin_x_(ground.rect.begin_x / kTile),
        begin_y_(ground.rect.begin_y / kTile),
        width_((ground.rect.end_x + kTile - 1) / kTile - begin_x_),
        height_((ground.rect.end_y + kTile - 1) / kTile - begin_y_),
        sums_(static_cast<size_t>(std::max(0, width_)) *
              static_cast<size_t>(std::max(0, height_))) {
    const ColumnRect& rect = ground.rect;
    for (int y = rect.begin_y; y < rect.end_y; ++y) {
      for (int x = rect.begin_x; x < rect.end_x; ++x) {
        Sums& sums = sums_[IndexOf(x / kTile, y / kTile)];
        for (const GroundNode& node : ground.At(ground.ColumnOf(x, y))) {
          if (!node.seen) continue;
          const int deviation = Deviation(ground, x, y, node.z);
          ++sums.count;
          (deviation > 0 ? sums.above : sums.below) +=
              static_cast<float>(std::abs(deviation));
        }
      }
    }
  }

  bool IsRough(int x, int y) const {
    Sums all;
    for (int ty = y / kTile - 1; ty <= y / kTile + 1; ++ty) {
      for (int tx = x / kTile - 1; tx <= x / kTile + 1; ++tx) {
        if (tx < begin_x_ || ty < begin_y_ || tx >= begin_x_ + width_ ||
            ty >= begin_y_ + height_) {
          continue;
        }
        const Sums& sums = sums_[IndexOf(tx, ty)];
        all.count += sums.count;
        all.above += sums.above;
        all.below += sums.below;
      }
    }
    return all.count > 0 && std::min(all.above, all.below) >
                                kRough * static_cast<float>(all.count);
  }

 private:
  struct Sums {
    int count = 0;
    float above = 0;
    float below = 0;
  };
  size_t IndexOf(int tile_x, int tile_y) const {
    return static_cast<size_t>(tile_y - begin_y_) *
               static_cast<size_t>(width_) +
           static_cast<size_t>(tile_x - begin_x_);
  }

  int begin_x_;
  int begin_y_;
  int width_;
  int height_;
  std::vector<Sums> sums_;
};

// A top that is to be moved.
struct Rough {
  int x = 0;
  int y = 0;
  size_t node = 0;
};

std::vector<Rough> FindRough(const GroundColumns& ground, const Tiles& tiles) {
  std::vector<Rough> rough;
  const ColumnRect& rect = ground.rect;
  for (int y = rect.begin_y; y < rect.end_y; ++y) {
    bool is_rough = false;
    for (int x = rect.begin_x; x < rect.end_x; ++x) {
      if (x == rect.begin_x || x % kTile == 0) is_rough = tiles.IsRough(x, y);
      if (!is_rough) continue;
      const size_t column = ground.ColumnOf(x, y);
      for (size_t i = ground.begin[column]; i < ground.begin[column + 1]; ++i) {
        rough.push_back({x, y, i});
      }
    }
  }
  return rough;
}

std::vector<int> HeightsAround(const GroundColumns& ground, const Rough& at,
                               int z, int reach, int scatter) {
  std::vector<int> heights;
  for (int y = at.y - reach; y <= at.y + reach; ++y) {
    for (int x = at.x - reach; x <= at.x + reach; ++x) {
      const GroundNode* near = TopNear(ground, x, y, z, scatter);
      if (near != nullptr) heights.push_back(near->z);
    }
  }
  return heights;
}

// All at once: none sees what others have become. Heights of one column stay in
// their order, with room between.
void Move(const std::vector<Rough>& rough, const std::vector<int>& heights,
          GroundColumns& ground) {
  for (size_t i = 0; i < rough.size(); ++i) {
    GroundNode& node = ground.nodes[rough[i].node];
    if (node.clearance != kOpenAbove) {
      node.clearance = std::max(0, node.clearance + node.z - heights[i]);
    }
    node.z = heights[i];
  }
}

}  // namespace

void SettleRoughGround(GroundColumns& ground) {
  const Tiles tiles(ground);
  const std::vector<Rough> rough = FindRough(ground, tiles);
  if (rough.empty()) return;
  std::vector<int> settled(rough.size());
  for (size_t i = 0; i < rough.size(); ++i) {
    std::vector<int> heights =
        HeightsAround(ground, rough[i], ground.nodes[rough[i].node].z,
                      kMedianReach, kScatter);
    const auto middle =
        heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    std::nth_element(heights.begin(), middle, heights.end());
    settled[i] = *middle;
  }
  Move(rough, settled, ground);
  for (size_t i = 0; i < rough.size(); ++i) {
    const int z = ground.nodes[rough[i].node].z;
    const std::vector<int> heights =
        HeightsAround(ground, rough[i], z, kMeanReach, kMeanScatter);
    int sum = 0;
    for (const int height : heights) sum += height - z;
    settled[i] =
        z + static_cast<int>(std::lround(
                static_cast<double>(sum) /
                static_cast<double>(std::max<size_t>(1, heights.size()))));
  }
  Move(rough, settled, ground);
}

}  // namespace treeline::traversability
