#include "nav_agent/behavior/obstacle_memory.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/behavior/obstacle_discs.h"
#include "nav_agent/behavior/testing_devices.h"

namespace treeline::behavior {
namespace {

constexpr NavigatorLimits kLimits;

planning::Blockage At(double x_m, double y_m, int level = 0) {
  return {.center = {x_m, y_m}, .radius_m = 0.2, .level = level};
}

// Beams from the origin to a wall at x = 4, or to what stands before it.
std::vector<geometry::Vec2> Beams(double blocked_from_y, double blocked_to_y) {
  std::vector<geometry::Vec2> ends;
  for (double y_m = -2; y_m < 2; y_m += 0.02) {
    const bool is_blocked = y_m / 2 > blocked_from_y && y_m / 2 < blocked_to_y;
    ends.push_back(is_blocked ? geometry::Vec2{2, y_m / 2}
                              : geometry::Vec2{4, y_m});
  }
  return ends;
}

bool Unseen(const planning::Blockage& /*blockage*/) { return false; }

TEST(ObstacleMemory, FadesAndLastsLongerWhenMetAgain) {
  ManualClock clock;
  ObstacleMemory memory(kLimits);
  memory.Add(At(2, 0), clock.Now());
  clock.Advance_s(kLimits.blockage_s - 1);
  EXPECT_EQ(memory.Fade(clock.Now()), 0);
  memory.Add(At(2.05, 0), clock.Now());
  EXPECT_EQ(memory.All().size(), 1u);
  clock.Advance_s(2 * kLimits.blockage_s - 1);
  EXPECT_EQ(memory.Fade(clock.Now()), 0);
  clock.Advance_s(2);
  EXPECT_EQ(memory.Fade(clock.Now()), 1);
  EXPECT_TRUE(memory.empty());
}

// A way that was planned around it, and that the band refuses at once.
TEST(ObstacleMemory, MetAgainAtOnceItIsLargerThanThought) {
  ManualClock clock;
  ObstacleMemory memory(kLimits);
  memory.Add(At(2, 0), clock.Now());
  // Another disc of the same look.
  memory.Add(At(2.05, 0), clock.Now());
  EXPECT_EQ(memory.All().at(0).radius_m, 0.2);
  clock.Advance_s(0.5);
  memory.Add(At(2, 0), clock.Now());
  EXPECT_NEAR(memory.All().at(0).radius_m, 0.23, 1e-9);
  // Much later it says nothing of its size.
  clock.Advance_s(5);
  memory.Add(At(2, 0), clock.Now());
  EXPECT_NEAR(memory.All().at(0).radius_m, 0.23, 1e-9);
}

TEST(ObstacleMemory, SeesThatNothingIsThereAnyMore) {
  ManualClock clock;
  ObstacleMemory memory(kLimits);
  memory.Add(At(2, 0), clock.Now());
  memory.Add(At(2, 0.8), clock.Now());
  for (int i = 0; i < 10; ++i) {
    // Something still stands at (2, 0.8).
    EXPECT_EQ(memory.SeeThrough(0, {0, 0}, Beams(0.7, 0.9), Unseen),
              i == 4 ? 1 : 0);
  }
  ASSERT_EQ(memory.All().size(), 1u);
  EXPECT_EQ(memory.All()[0].center.y, 0.8);
}

TEST(ObstacleMemory, OneScanOrAnotherLevelOrFarAwayIsNotEnough) {
  ManualClock clock;
  ObstacleMemory memory(kLimits);
  memory.Add(At(2, 0, 1), clock.Now());
  memory.Add(At(6, 0), clock.Now());
  memory.Add(At(2, 0), clock.Now());
  for (int i = 0; i < 20; ++i) {
    memory.SeeThrough(0, {0, 0}, i % 2 == 0 ? Beams(1, 1) : Beams(-0.1, 0.1),
                      Unseen);
  }
  EXPECT_EQ(memory.All().size(), 3u);
}

TEST(ObstacleMemory, WhatTheLaserLooksOverAndTheCameraSeesIsNotForgotten) {
  ManualClock clock;
  ObstacleMemory memory(kLimits);
  memory.Add(At(2, 0), clock.Now());
  bool is_seen = true;
  const auto seen = [&is_seen](const planning::Blockage&) { return is_seen; };
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(memory.SeeThrough(0, {0, 0}, Beams(0.7, 0.9), seen), 0);
  }
  is_seen = false;
  int forgotten = 0;
  for (int i = 0; i < 5; ++i) {
    forgotten += memory.SeeThrough(0, {0, 0}, Beams(0.7, 0.9), seen);
  }
  EXPECT_EQ(forgotten, 1);
}

TEST(ObstacleDiscs, FollowTheShapeThatHangsTogether) {
  control::CostmapView costmap;
  costmap.origin_in_map = {-2, -2};
  costmap.width = 80;
  costmap.height = 80;
  costmap.cells.assign(6400, 0);
  const auto mark = [&](double x_m, double y_m, uint8_t value) {
    const auto x = static_cast<size_t>((x_m + 2) / 0.05);
    const auto y = static_cast<size_t>((y_m + 2) / 0.05);
    costmap.cells[y * 80 + x] = value;
  };
  // A front of 1 m at x = 1; something of the map; something else, far away.
  for (double y_m = -0.5; y_m <= 0.5; y_m += 0.05) mark(1.01, y_m, 2);
  mark(1.01, 1.0, 1);
  mark(1.01, 1.5, 2);
  const std::vector<planning::Blockage> discs =
      DiscsOf(costmap, {1, 0}, {0, 0}, 0.05, 0.3, 1);
  ASSERT_GE(discs.size(), 8u);
  double min_distance_m = 1;
  double max_m = -1;
  for (const planning::Blockage& disc : discs) {
    EXPECT_EQ(disc.level, 1);
    EXPECT_EQ(disc.radius_m, 0.05);
    EXPECT_GT(disc.center.x, 0.95);
    min_distance_m = std::min(min_distance_m, disc.center.y);
    max_m = std::max(max_m, disc.center.y);
  }
  EXPECT_LT(min_distance_m, -0.25);
  EXPECT_GT(max_m, 0.25);
  EXPECT_LT(max_m, 0.8);
}

TEST(ObstacleDiscs, AreOneWhereNothingWasSeen) {
  const std::vector<planning::Blockage> discs =
      DiscsOf({}, {1, 0}, {0, 0}, 0.05, 0.3, 0);
  ASSERT_EQ(discs.size(), 1u);
  EXPECT_EQ(discs[0].radius_m, 0.3);
}

}  // namespace
}  // namespace treeline::behavior
