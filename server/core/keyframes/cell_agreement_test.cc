#include "server/core/keyframes/cell_agreement.h"

#include <cmath>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::keyframes {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr int kPointsOfCell = 20;
// With one more they tell.
constexpr int kFewPoints = static_cast<int>(kMinCellPoints.value) - 1;

// Points in every cell, with what is expected there. `show(column, row,
// expected)` is what the picture has.
template <typename Show>
double ContradictedWhere(const Show& show) {
  CellAgreement cells(kWidth, kHeight);
  base::Random random(1, 0);
  for (int row = 0; row < kCellRows; ++row) {
    for (int column = 0; column < kCellColumns; ++column) {
      for (int i = 0; i < kPointsOfCell; ++i) {
        const auto within = [&](int cell, int cells_of, int size) {
          return static_cast<float>((cell + random.NextUniform(0.01, 0.99)) *
                                    size / cells_of);
        };
        const auto expected = static_cast<float>(random.NextUniform(20, 230));
        const float seen = show(column, row, expected);
        cells.Add(within(column, kCellColumns, kWidth),
                  within(row, kCellRows, kHeight), expected, seen,
                  std::abs(seen - expected) <= 15);
      }
    }
  }
  return cells.Contradicted();
}

bool IsPoster(int column, int row) { return column < 2 && row == 3; }
constexpr double kPoster = 2.0 / (8 * 6);

TEST(CellAgreementTest, AnotherPosterContradicts) {
  base::Random random(2, 0);
  EXPECT_DOUBLE_EQ(
      ContradictedWhere([&](int column, int row, float expected) {
        return IsPoster(column, row)
                   ? static_cast<float>(random.NextUniform(20, 230))
                   : expected;
      }),
      kPoster);
}

TEST(CellAgreementTest, SoDoesABareWall) {
  EXPECT_DOUBLE_EQ(ContradictedWhere([](int column, int row, float expected) {
                     return IsPoster(column, row) ? 120.0F : expected;
                   }),
                   kPoster);
}

TEST(CellAgreementTest, AnotherLightDoesNot) {
  EXPECT_EQ(ContradictedWhere([](int column, int row, float expected) {
              return IsPoster(column, row) ? 0.3F * expected + 10 : expected;
            }),
            0);
}

TEST(CellAgreementTest, NorDoesNoiseThatIsEverywhere) {
  base::Random random(3, 0);
  EXPECT_EQ(ContradictedWhere([&](int, int, float expected) {
              return expected + static_cast<float>(random.NextUniform(-60, 60));
            }),
            0);
}

TEST(CellAgreementTest, FewPointsTellNothing) {
  CellAgreement cells(kWidth, kHeight);
  for (int i = 0; i < kFewPoints; ++i) {
    cells.Add(5, 5, 30.0F * static_cast<float>(i), 100, false);
  }
  EXPECT_EQ(cells.Contradicted(), 0);
  cells.Add(5, 5, 0, 100, false);
  EXPECT_EQ(cells.Contradicted(), 1);
}

TEST(CellAgreementTest, PixelsOnTheEdgeBelongToTheLastCells) {
  CellAgreement cells(kWidth, kHeight);
  for (int i = 0; i <= kFewPoints; ++i) {
    cells.Add(kWidth, kHeight, 30.0F * static_cast<float>(i), 100, false);
  }
  EXPECT_EQ(cells.Contradicted(), 1);
}

}  // namespace
}  // namespace treeline::keyframes
