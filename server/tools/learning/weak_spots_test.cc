#include "server/tools/learning/weak_spots.h"

#include <cmath>
#include <numbers>

#include "gtest/gtest.h"

namespace treeline::learning {
namespace {

using keyframes::CoverageMap;

constexpr uint32_t kAllHeadings = 0xffff;

// A hall of 8 m x 6 m, answered everywhere.
CoverageMap Hall() {
  CoverageMap coverage{.min_x_m = -4,
                       .min_y_m = -3,
                       .cell_m = 0.25,
                       .columns = 32,
                       .rows = 24,
                       .headings = 16};
  coverage.places.assign(32 * 24, {.is_open = true, .good = kAllHeadings});
  return coverage;
}

// Sets what is answered within `radius_m` of (x, y).
void SetAround(CoverageMap& coverage, double x, double y, double radius_m,
               uint32_t good) {
  for (int r = 0; r < coverage.rows; ++r) {
    for (int c = 0; c < coverage.columns; ++c) {
      const double px = coverage.min_x_m + (c + 0.5) * coverage.cell_m;
      const double py = coverage.min_y_m + (r + 0.5) * coverage.cell_m;
      if (std::hypot(px - x, py - y) > radius_m) continue;
      coverage.places[static_cast<size_t>(r * coverage.columns + c)].good =
          good;
    }
  }
}

TEST(WeakSpotsTest, AHallThatIsAnsweredEverywhereHasNone) {
  EXPECT_TRUE(FindWeakSpots(Hall(), 4).empty());
}

TEST(WeakSpotsTest, AHoleIsFoundWhereItIs) {
  CoverageMap coverage = Hall();
  SetAround(coverage, 2, -1, 0.8, 0);
  const auto spots = FindWeakSpots(coverage, 4);
  ASSERT_EQ(spots.size(), 1u);
  // Anywhere in the hole: its disc lies inside.
  EXPECT_LE(std::hypot(spots[0].x_m - 2, spots[0].y_m + 1), 0.5);
  EXPECT_NEAR(spots[0].missing_share, 1, 1e-9);
  EXPECT_FALSE(spots[0].towards_rad.has_value());
}

TEST(WeakSpotsTest, TheLargerHoleComesFirstAndTheyAreApart) {
  CoverageMap coverage = Hall();
  SetAround(coverage, 2, -1, 1.0, 0);
  SetAround(coverage, -3, 2, 0.5, 0);
  const auto spots = FindWeakSpots(coverage, 2);
  ASSERT_EQ(spots.size(), 2u);
  EXPECT_LE(std::hypot(spots[0].x_m - 2, spots[0].y_m + 1), 0.7);
  EXPECT_LE(std::hypot(spots[1].x_m + 3, spots[1].y_m - 2), 0.7);
}

TEST(WeakSpotsTest, TheDirectionIsThatOfTheMissingHeadings) {
  CoverageMap coverage = Hall();
  // Headings 0 to 7 of 16 are the upper half of the circle, from 0 to 157
  // degrees; they are missing.
  SetAround(coverage, 0, 0, 1.0, 0xff00);
  const auto spots = FindWeakSpots(coverage, 4);
  ASSERT_GE(spots.size(), 1u);
  ASSERT_TRUE(spots[0].towards_rad.has_value());
  EXPECT_NEAR(*spots[0].towards_rad * 180 / std::numbers::pi, 78.75, 1);
  EXPECT_EQ(DirectionOnPlan(*spots[0].towards_rad), "the top of the plan");
}

TEST(WeakSpotsTest, WhatIsNotOpenIsNotMissing) {
  CoverageMap coverage = Hall();
  for (auto& place : coverage.places) place = {};
  EXPECT_TRUE(FindWeakSpots(coverage, 4).empty());
}

TEST(WeakSpotsTest, DirectionsAreAsOnAPlan) {
  constexpr double kDegree = std::numbers::pi / 180;
  EXPECT_EQ(DirectionOnPlan(0), "the right of the plan");
  EXPECT_EQ(DirectionOnPlan(50 * kDegree), "the top right of the plan");
  EXPECT_EQ(DirectionOnPlan(180 * kDegree), "the left of the plan");
  EXPECT_EQ(DirectionOnPlan(-180 * kDegree), "the left of the plan");
  EXPECT_EQ(DirectionOnPlan(-85 * kDegree), "the bottom of the plan");
}

}  // namespace
}  // namespace treeline::learning
