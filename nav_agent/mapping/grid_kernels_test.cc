#include "nav_agent/mapping/grid_kernels.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"

namespace treeline::mapping {
namespace {

std::vector<uint8_t> RandomBytes(size_t count, uint64_t seed) {
  base::Random random(seed, 0);
  std::vector<uint8_t> bytes(count);
  for (uint8_t& byte : bytes) {
    byte = static_cast<uint8_t>(random.NextBelow(256));
  }
  return bytes;
}

TEST(GridKernels, TheLargerOfTwo) {
  base::WithEachVectorTarget([&] {
    for (const size_t count : std::vector<size_t>{0, 1, 15, 16, 31, 64, 129}) {
      const std::vector<uint8_t> a = RandomBytes(count, 1);
      const std::vector<uint8_t> b = RandomBytes(count, 2);
      std::vector<uint8_t> to(count + 1, 7);
      WriteLarger(a.data(), b.data(), to.data(), count);
      for (size_t i = 0; i < count; ++i) EXPECT_EQ(to[i], std::max(a[i], b[i]));
      EXPECT_EQ(to[count], 7);
    }
  });
}

TEST(GridKernels, ASegmentIsDrawnWhereItIsNearest) {
  base::WithEachVectorTarget([&] {
    constexpr int kWidth = 37;
    constexpr int kHeight = 29;
    constexpr double kReach = 3.75;
    std::vector<uint32_t> cells(size_t{kWidth} * kHeight + kGridSlack,
                                kNoPiece);
    std::vector<double> nearest(size_t{kWidth} * kHeight, kReach * kReach);
    base::Random random(5, 0);
    for (uint32_t piece = 0; piece < 40; ++piece) {
      GridSegment segment = {.begin_x = -5 + 45 * random.NextUnit(),
                             .begin_y = -5 + 38 * random.NextUnit(),
                             .along_x = 8 * random.NextUnit() - 4,
                             .along_y = 8 * random.NextUnit() - 4,
                             .reach = kReach};
      if (piece % 5 == 0) segment.along_y = 0;
      if (piece % 7 == 0) segment.along_x = 0;
      const double x2 = segment.begin_x + segment.along_x;
      const double y2 = segment.begin_y + segment.along_y;
      const auto low = [&](double a, double b) {
        return std::max(0, static_cast<int>(std::min(a, b) - kReach));
      };
      segment.left = low(segment.begin_x, x2);
      segment.bottom = low(segment.begin_y, y2);
      segment.right = std::min(
          kWidth - 1, static_cast<int>(std::max(segment.begin_x, x2) + kReach));
      segment.top =
          std::min(kHeight - 1,
                   static_cast<int>(std::max(segment.begin_y, y2) + kReach));
      DrawSegment(segment, piece, 32, 450, kWidth, cells.data());
      const double length2 =
          segment.along_x * segment.along_x + segment.along_y * segment.along_y;
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          const double dx = x - segment.begin_x;
          const double dy = y - segment.begin_y;
          const double t = std::clamp(
              length2 > 0
                  ? (dx * segment.along_x + dy * segment.along_y) / length2
                  : 0.0,
              0.0, 1.0);
          const double off2 = std::pow(dx - t * segment.along_x, 2) +
                              std::pow(dy - t * segment.along_y, 2);
          double& least = nearest[static_cast<size_t>(y * kWidth + x)];
          least = std::min(least, off2);
        }
      }
    }
    for (size_t i = 0; i < nearest.size(); ++i) {
      if (nearest[i] > kReach * kReach - 0.1) continue;
      EXPECT_NEAR(cells[i] >> kPieceBits, 32 * nearest[i], 1.01);
    }
    for (size_t i = nearest.size(); i < cells.size(); ++i) {
      EXPECT_EQ(cells[i], kNoPiece);
    }
  });
}

// As many points of 255 as do not fit into 16 bits.
TEST(GridKernels, SumsOfWindows) {
  base::WithEachVectorTarget([&] {
    constexpr int kWidth = 40;
    std::vector<uint8_t> cells = RandomBytes(size_t{kWidth} * 30, 3);
    cells[3 * kWidth + 4] = 255;
    std::vector<int32_t> offsets(600, 3 * kWidth + 4);
    for (int i = 0; i < 37; ++i) offsets.push_back(i);
    WindowSums sums;
    SumWindows(cells.data(), offsets, kWidth, sums);
    for (int y = 0; y < kSumWindow; ++y) {
      for (int x = 0; x < kSumWindow; ++x) {
        uint32_t sum = 0;
        for (const int32_t offset : offsets) {
          sum += cells[static_cast<size_t>(offset + y * kWidth + x)];
        }
        EXPECT_EQ(sums[static_cast<size_t>(y * kSumRow + x)], sum);
      }
    }
    SumWindows(cells.data(), {}, kWidth, sums);
    EXPECT_EQ(*std::ranges::max_element(sums), 0);
  });
}

}  // namespace
}  // namespace treeline::mapping
