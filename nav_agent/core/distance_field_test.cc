#include "nav_agent/core/distance_field.h"

#include <algorithm>
#include <cmath>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::core {
namespace {

// By trying all pairs.
std::vector<int32_t> Slowly(int width, int height,
                            const std::vector<uint8_t>& is_obstacle) {
  std::vector<int32_t> result;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      int32_t best = kNoObstacle;
      for (int v = 0; v < height; ++v) {
        for (int u = 0; u < width; ++u) {
          if (is_obstacle[static_cast<size_t>(v * width + u)] == 0) continue;
          best = std::min(best, (u - x) * (u - x) + (v - y) * (v - y));
        }
      }
      result.push_back(best);
    }
  }
  return result;
}

TEST(SquaredDistances, AreExact) {
  base::Random random(7, 1);
  for (int trial = 0; trial < 60; ++trial) {
    const int width = 1 + static_cast<int>(random.NextBelow(24));
    const int height = 1 + static_cast<int>(random.NextBelow(24));
    const double density = trial % 5 == 0 ? 0.002 : random.NextUniform(0, 0.3);
    std::vector<uint8_t> cells(static_cast<size_t>(width * height));
    for (uint8_t& cell : cells) cell = random.NextUnit() < density ? 1 : 0;
    EXPECT_EQ(SquaredDistances(width, height, cells),
              Slowly(width, height, cells))
        << "trial " << trial;
  }
}

TEST(DistanceToOccupied, IsInMetresAndBounded) {
  OccupancyGrid grid = OccupancyGrid::Filled(5, 1, 0.5, {}, Occupancy::kFree);
  grid.Set({0, 0}, Occupancy::kOccupied);
  grid.Set({4, 0}, Occupancy::kUnknown);
  const std::vector<float> distances = DistanceToOccupied(grid, 1.2);
  const float expected[] = {0, 0.5f, 1, 1.2f, 1.2f};
  for (size_t i = 0; i < 5; ++i) EXPECT_FLOAT_EQ(distances[i], expected[i]);
  grid.Set({0, 0}, Occupancy::kFree);
  EXPECT_FLOAT_EQ(DistanceToOccupied(grid, 1.2)[0], 1.2f);
}

}  // namespace
}  // namespace treeline::core
