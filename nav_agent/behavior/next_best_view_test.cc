#include "nav_agent/behavior/next_best_view.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::behavior {
namespace {

// A wall 0.5 m to the left, things at 2 to 4 m to the right, nothing elsewhere.
std::vector<geometry::Vec2> Scan() {
  std::vector<geometry::Vec2> ends;
  for (int i = -130; i <= 130; ++i) {
    const double angle_rad = i * 0.01745;
    double range_m = 12;
    if (i > 45) range_m = 0.5;
    if (i < -45) range_m = (i / 5) % 2 == 0 ? 2 : 4;
    ends.push_back(
        {range_m * std::cos(angle_rad), range_m * std::sin(angle_rad)});
  }
  return ends;
}

TEST(NextBestView, PrefersThingsAtSomeDistanceToWallsNearBy) {
  NextBestView belief;
  belief.Begin({});
  belief.AddScan({}, Scan());
  EXPECT_GT(belief.Chance(-1.57), belief.Chance(1.57) + 0.3);
  const auto next_rad = belief.Next(0, std::nullopt, 0.05);
  ASSERT_TRUE(next_rad.has_value());
  EXPECT_LT(*next_rad, -0.7);
}

TEST(NextBestView, DoesNotAskTwiceInADirectionThatSaidNothing) {
  NextBestView belief;
  belief.Begin({});
  belief.AddScan({}, Scan());
  const double first_rad = *belief.Next(0, std::nullopt, 0.05);
  belief.AddAnswer(first_rad, 0.03);
  const double second_rad = *belief.Next(first_rad, std::nullopt, 0.05);
  EXPECT_GT(std::abs(geometry::NormalizedAngle_rad(second_rad - first_rad)),
            0.4);
}

TEST(NextBestView, GivesUpWhenAllDirectionsSaidNothing) {
  NextBestView belief;
  belief.Begin({});
  int asked = 0;
  double yaw_rad = 0;
  while (asked < 100) {
    const auto next_rad = belief.Next(yaw_rad, std::nullopt, 0.06);
    if (!next_rad.has_value()) break;
    yaw_rad = *next_rad;
    belief.AddAnswer(yaw_rad, 0.03);
    ++asked;
  }
  // A picture a field of view, about.
  EXPECT_GE(asked, 6);
  EXPECT_LE(asked, 16);
}

TEST(NextBestView, ASecondViewLiesBesideTheFirst) {
  NextBestView belief;
  belief.Begin({});
  belief.AddAnswer(1, 0.6);
  const double second_rad = *belief.Next(1, 1.0, 0.05);
  EXPECT_GT(std::abs(second_rad - 1), 0.3);
  EXPECT_LT(std::abs(second_rad - 1), 1.0);
}

TEST(NextBestView, WhereTheSecondViewSaidNothingItDoesNotLookAgain) {
  NextBestView belief;
  belief.Begin({});
  belief.AddAnswer(1, 0.6);
  std::vector<double> looked_rad;
  double yaw_rad = 1;
  for (int i = 0; i < 4; ++i) {
    yaw_rad = *belief.Next(yaw_rad, 1.0, 0.05);
    for (const double before_rad : looked_rad) {
      EXPECT_GT(std::abs(yaw_rad - before_rad), 0.25);
    }
    looked_rad.push_back(yaw_rad);
    belief.AddAnswer(yaw_rad, 0.03);
  }
}

}  // namespace
}  // namespace treeline::behavior
