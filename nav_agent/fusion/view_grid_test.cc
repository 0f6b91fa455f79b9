#include "nav_agent/fusion/view_grid.h"

#include <bit>
#include <cmath>
#include <cstdlib>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::fusion {
namespace {

bool IsFree(const ViewGrid& grid, octree::VoxelIndex v) {
  return (grid.Free(v.x, v.y, v.z / 8) >> (v.z % 8) & 1) != 0;
}

int CountFree(const ViewGrid& grid) {
  int count = 0;
  for (int x = 0; x < grid.blocks().x * 8; ++x) {
    for (int y = 0; y < grid.blocks().y * 8; ++y) {
      for (int z = 0; z < grid.blocks().z; ++z) {
        count += std::popcount(unsigned{grid.Free(x, y, z)});
      }
    }
  }
  return count;
}

octree::VoxelIndex VoxelAt(geometry::Vec3 place) {
  return {static_cast<int>(place.x), static_cast<int>(place.y),
          static_cast<int>(place.z)};
}

TEST(ViewGrid, RaysPassAllVoxelsOnTheirWayButNotTheLast) {
  ViewGrid grid;
  base::Random random(1, 0);
  const auto draw = [&random] {
    return geometry::Vec3{random.NextUniform(1, 23), random.NextUniform(1, 31),
                          random.NextUniform(1, 39)};
  };
  for (int ray = 0; ray < 300; ++ray) {
    grid.Reset({}, {3, 4, 5});
    const geometry::Vec3 from = draw();
    const geometry::Vec3 to = draw();
    grid.MarkFree(from, to);
    const octree::VoxelIndex first = VoxelAt(from);
    const octree::VoxelIndex last = VoxelAt(to);
    EXPECT_EQ(CountFree(grid), std::abs(last.x - first.x) +
                                   std::abs(last.y - first.y) +
                                   std::abs(last.z - first.z));
    EXPECT_FALSE(IsFree(grid, last));
    for (int i = 0; i < 2000; ++i) {
      const octree::VoxelIndex v = VoxelAt(from + i / 2000.0 * (to - from));
      EXPECT_TRUE(IsFree(grid, v) || v == last);
    }
  }
}

TEST(ViewGrid, RaysAlongAnAxisAndOfNoLength) {
  ViewGrid grid;
  grid.Reset({}, {2, 2, 2});
  grid.MarkFree({4, 4, 4}, {4, 4, 4});
  EXPECT_EQ(CountFree(grid), 0);
  grid.MarkFree({4, 4, 12}, {4, 4, 3});
  EXPECT_EQ(CountFree(grid), 9);
  EXPECT_TRUE(IsFree(grid, {4, 4, 4}));
  EXPECT_FALSE(IsFree(grid, {4, 4, 3}));
}

}  // namespace
}  // namespace treeline::fusion
