// The layers of a local costmap, each alone.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/control/costmap_window.h"
#include "nav_agent/control/depth_observer.h"
#include "nav_agent/control/distance_layer.h"
#include "nav_agent/control/ground_layer.h"
#include "nav_agent/control/laser_observer.h"
#include "nav_agent/control/observed_obstacles.h"
#include "nav_agent/control/obstacle_layer.h"
#include "nav_agent/control/testing_floor.h"

namespace treeline::control {
namespace {

const core::RobotModel kRobot;

// 4 x 4 m about (6, 6).
CostmapWindow WindowAt6() {
  return CostmapWindow(4, 4, 0.05).CenteredAt({6, 6});
}

size_t IndexAt(const CostmapWindow& window, geometry::Vec2 in_map) {
  const core::CellIndex cell = window.CellOf(in_map);
  return window.IndexOf(cell.x, cell.y);
}

GroundLayer GroundOf(const TestingFloor& floor, const CostmapWindow& window) {
  GroundLayer ground(floor.Map(), window.cells());
  ground.Spread(window, TestingPose(6, 6).pose);
  return ground;
}

// A look of a laser at cells, ms after the epoch.
void Look(ObstacleLayer& obstacles, const std::vector<size_t>& cells,
          int64_t now_ms) {
  obstacles.BeginLook();
  for (const size_t i : cells) obstacles.Hit(i);
  obstacles.MarkLaserHits(now_ms);
}

TEST(CostmapWindow, RollsByWholeCells) {
  const CostmapWindow window = WindowAt6();
  EXPECT_EQ(window.width(), 80);
  EXPECT_NEAR(window.origin_in_map().x, 4, 1e-12);
  const CostmapWindow near = window.CenteredAt({6.02, 5.98});
  EXPECT_TRUE(near.IsSamePlaceAs(window));
  const CostmapWindow ahead = window.CenteredAt({6.04, 6});
  EXPECT_EQ(ahead.cell_x(), window.cell_x() + 1);
  EXPECT_EQ(ahead.cell_y(), window.cell_y());
  // A place keeps its cell's middle.
  const geometry::Vec2 at = {5.03, 6.41};
  const core::CellIndex before = window.CellOf(at);
  const core::CellIndex after = ahead.CellOf(at);
  EXPECT_EQ(after.x, before.x - 1);
  EXPECT_NEAR(ahead.CenterInMap(after.x, after.y).x,
              window.CenterInMap(before.x, before.y).x, 1e-12);
  EXPECT_TRUE(window.Contains({7.9, 6}));
  EXPECT_FALSE(window.Contains({7.9, 6}, 0.2));
}

TEST(GroundLayer, SpreadsUpARampAndNotOverADrop) {
  TestingFloor floor;
  floor.Ramp({6.5, 0}, {12, 12}, 0.3).Raise({4, 7}, {5, 8}, 0.5);
  const CostmapWindow window = WindowAt6();
  const GroundLayer ground = GroundOf(floor, window);
  const size_t up = IndexAt(window, {7.72, 6});
  ASSERT_TRUE(ground.IsGround(up));
  EXPECT_GT(ground.Height_m(up), 0.3);
  EXPECT_FALSE(ground.IsGround(IndexAt(window, {4.5, 7.5})));
  EXPECT_NEAR(ground.MapDistance_m(IndexAt(window, {5.175, 7.5})), 0.2, 0.03);
  // 0.2 m above the floor something stands; above the ramp it is the ramp.
  EXPECT_TRUE(ground.IsHeightOfObstacle(window, window.CellOf({6, 6}), 0.3, 1,
                                        kRobot.height_m));
  EXPECT_FALSE(ground.IsHeightOfObstacle(window, window.CellOf({7.4, 6}), 0.3,
                                         1, kRobot.height_m));
  EXPECT_FALSE(ground.IsHeightOfObstacle(window, window.CellOf({6, 6}), 1.3, 1,
                                         kRobot.height_m));
}

TEST(GroundLayer, WithoutAMapAllIsLevelGround) {
  TestingFloor floor;
  floor.Fill({0, 0}, {12, 12}, core::Occupancy::kOccupied)
      .Fill({1, 1}, {2, 2}, core::Occupancy::kFree);
  const CostmapWindow window = WindowAt6();
  GroundLayer ground = GroundOf(floor, window);
  EXPECT_FALSE(ground.IsGround(IndexAt(window, {6, 6})));
  ground.SpreadLevel(window, TestingPose(6, 6).pose);
  EXPECT_TRUE(ground.IsGround(IndexAt(window, {6, 6})));
  EXPECT_TRUE(ground.map_is_unknown());
  EXPECT_EQ(ground.MapDistance_m(0), std::numeric_limits<float>::infinity());
}

TEST(GroundLayer, TheMapsObstaclesAreItsEdges) {
  TestingFloor floor;
  floor.Fill({6.5, 5.5}, {7.5, 6.5}, core::Occupancy::kOccupied);
  const GroundLayer ground = GroundOf(floor, WindowAt6());
  const std::vector<geometry::Vec2> obstacles =
      ground.MapObstacles(TestingPose(6, 6).pose, 1.0);
  ASSERT_FALSE(obstacles.empty());
  for (const geometry::Vec2& at : obstacles) {
    const double inside_m = std::min({at.x - 6.5, at.y - 5.5, 6.5 - at.y});
    EXPECT_LT(inside_m, 0.05);
  }
}

TEST(ObstacleLayer, ThreeLooksMarkAndLooksThroughClear) {
  const CostmapWindow window = WindowAt6();
  const GroundLayer ground = GroundOf(TestingFloor(), window);
  ObstacleLayer obstacles(window.cells(), false);
  const size_t cell = IndexAt(window, {7, 6});
  Look(obstacles, {cell}, 1);
  Look(obstacles, {cell, cell}, 26);
  EXPECT_FALSE(obstacles.Counts(cell));
  Look(obstacles, {cell}, 51);
  EXPECT_TRUE(obstacles.Counts(cell));
  EXPECT_TRUE(obstacles.IsSeenNow(cell, 151));
  EXPECT_FALSE(obstacles.IsSeenNow(cell, 251));
  EXPECT_EQ(obstacles.Age_ms(cell, 101), 100);
  obstacles.BeginLook();
  obstacles.ClearAlong(window, ground, {6, 6, 0.35}, {8, 6, 0.35}, 76);
  obstacles.ClearAlong(window, ground, {6, 6, 0.35}, {8, 6, 0.35}, 76);
  // Once a look: 3 hits less 2.
  Look(obstacles, {cell}, 101);
  Look(obstacles, {cell}, 126);
  EXPECT_TRUE(obstacles.Counts(cell));
}

TEST(ObstacleLayer, ABeamHighAboveTheGroundClearsNothing) {
  const CostmapWindow window = WindowAt6();
  const GroundLayer ground = GroundOf(TestingFloor(), window);
  ObstacleLayer obstacles(window.cells(), false);
  const size_t cell = IndexAt(window, {7, 6});
  for (int i = 0; i < 3; ++i) Look(obstacles, {cell}, 1 + 25 * i);
  for (int i = 0; i < 5; ++i) {
    obstacles.BeginLook();
    obstacles.ClearAlong(window, ground, {6, 6, 0.8}, {8, 6, 0.8}, 100);
  }
  EXPECT_TRUE(obstacles.Counts(cell));
}

TEST(ObstacleLayer, OneOfTwoLasersDoesNotClearWhatTheOtherJustHit) {
  const CostmapWindow window = WindowAt6();
  const GroundLayer ground = GroundOf(TestingFloor(), window);
  const size_t cell = IndexAt(window, {7, 6});
  for (const bool has_two : {false, true}) {
    ObstacleLayer obstacles(window.cells(), has_two);
    for (int i = 0; i < 3; ++i) {
      Look(obstacles, {cell}, 1 + 50 * i);
      obstacles.BeginLook();
      obstacles.ClearAlong(window, ground, {6, 6, 0.35}, {8, 6, 0.35},
                           26 + 50 * i);
    }
    EXPECT_EQ(obstacles.Counts(cell), has_two);
  }
}

TEST(ObstacleLayer, WhatStoodIsRememberedForLongerThanWhatMoved) {
  const CostmapWindow window = WindowAt6();
  ObstacleLayer obstacles(window.cells(), false);
  const size_t stood = IndexAt(window, {7, 6});
  const size_t moved = IndexAt(window, {6, 7});
  for (int i = 0; i < 60; ++i) Look(obstacles, {stood}, 1 + 25 * i);
  for (int i = 57; i < 60; ++i) Look(obstacles, {moved}, 1 + 25 * i);
  obstacles.Forget(3000);
  EXPECT_TRUE(obstacles.Counts(moved));
  obstacles.Forget(5000);
  EXPECT_FALSE(obstacles.Counts(moved));
  EXPECT_TRUE(obstacles.Counts(stood));
  obstacles.Forget(70000);
  EXPECT_FALSE(obstacles.Counts(stood));
}

TEST(ObstacleLayer, RollsAlongWithTheWindow) {
  const CostmapWindow window = WindowAt6();
  ObstacleLayer obstacles(window.cells(), false);
  for (int i = 0; i < 3; ++i) {
    Look(obstacles, {IndexAt(window, {7.025, 6.025})}, 1 + 25 * i);
  }
  const CostmapWindow ahead = window.CenteredAt({6.5, 6.2});
  obstacles.Roll(window, ahead);
  EXPECT_TRUE(obstacles.Counts(IndexAt(ahead, {7.025, 6.025})));
  const CostmapWindow away = window.CenteredAt({2, 2});
  obstacles.Roll(ahead, away);
  for (size_t i = 0; i < away.cells(); ++i) ASSERT_FALSE(obstacles.Counts(i));
}

TEST(ObstacleLayer, WhatIsNewIsWidenedAndWhatIsNearTheMapIsNot) {
  TestingFloor floor;
  floor.Fill({7, 0}, {7.05, 12}, core::Occupancy::kOccupied);
  const CostmapWindow window = WindowAt6();
  const GroundLayer ground = GroundOf(floor, window);
  ObstacleLayer obstacles(window.cells(), false);
  const size_t away = IndexAt(window, {5.025, 6.025});
  const size_t beside = IndexAt(window, {6.875, 6.025});
  for (int i = 0; i < 3; ++i) Look(obstacles, {away, beside}, 1 + 25 * i);
  EXPECT_TRUE(obstacles.IsNew(away, ground));
  EXPECT_FALSE(obstacles.IsNew(beside, ground));
  std::vector<uint8_t> is_obstacle(window.cells(), 0);
  obstacles.Widen(window, ground, is_obstacle);
  EXPECT_EQ(is_obstacle[IndexAt(window, {5.125, 6.025})], 1);
  EXPECT_EQ(is_obstacle[IndexAt(window, {6.775, 6.025})], 0);
}

TEST(LaserObserver, ABeamAloneIsAnEcho) {
  const CostmapWindow window = WindowAt6();
  const GroundLayer ground = GroundOf(TestingFloor(), window);
  ObstacleLayer obstacles(window.cells(), false);
  LaserObserver laser(TestingLaser(), kRobot.base_from_laser, kRobot.height_m,
                      8);
  const ControlPose pose = TestingPose(6, 6);
  core::LaserScan scan = TestingScan(pose, NothingThere);
  EXPECT_TRUE(laser.Check(scan).ok());
  scan.ranges_m[270] = 1.0F;
  laser.Add(pose, scan, window, ground, 1, obstacles);
  EXPECT_TRUE(laser.points().empty());
  EXPECT_TRUE(obstacles.hits().empty());
  scan.ranges_m[271] = 1.05F;
  laser.Add(pose, scan, window, ground, 26, obstacles);
  EXPECT_EQ(laser.points().size(), 2u);
  EXPECT_EQ(obstacles.hits().size(), 2u);
  EXPECT_NEAR(laser.points()[0].in_map.x, 6 + 0.22 + 1, 0.01);
  scan.ranges_m.pop_back();
  EXPECT_EQ(laser.Check(scan).code(), absl::StatusCode::kInvalidArgument);
}

TEST(DepthObserver, AFrameWithoutDepthIsRefused) {
  EXPECT_EQ(DepthObserver::Check(core::RgbdFrame()).code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(DistanceLayer, IsExactBetweenCellsAndUnknownOutside) {
  const CostmapWindow window = WindowAt6();
  DistanceLayer distances(window, Footprint::Of(kRobot));
  std::vector<uint8_t> is_obstacle(window.cells(), 0);
  distances.Measure(window, is_obstacle, 8);
  EXPECT_EQ(distances.Distance_m({6, 6}), 8 - 0.025);
  is_obstacle[IndexAt(window, {7.025, 6.025})] = 1;
  distances.Measure(window, is_obstacle, 8);
  // To the cell's near side.
  EXPECT_NEAR(distances.Distance_m({6.5, 6.025}), 0.5, 1e-6);
  EXPECT_LT(distances.Distance_m({3.9, 6}), 0);
  EXPECT_NEAR(distances.Away({6.5, 6.025}).x, -1, 1e-3);
  // Its front is 0.3 m ahead.
  EXPECT_NEAR(distances.FootprintDistance_m({.translation = {6.5, 6.025}}, 1.0),
              0.2, 0.01);
  EXPECT_LT(distances.FootprintDistance_m({.translation = {7, 6}}, 1.0), 0);
}

TEST(SeenObstacles, HangTogetherOverGapsOfACell) {
  const CostmapWindow window = WindowAt6();
  const GroundLayer ground = GroundOf(TestingFloor(), window);
  ObstacleLayer obstacles(window.cells(), false);
  const std::vector<size_t> cells = {IndexAt(window, {7.025, 6.025}),
                                     IndexAt(window, {7.125, 6.025}),
                                     IndexAt(window, {7.325, 6.025})};
  for (int i = 0; i < 3; ++i) Look(obstacles, cells, 1000 + 25 * i);
  const ObservedObstacle seen =
      ObservedObstacleNear(window, ground, obstacles, {7, 6}, 0.5, 3000);
  EXPECT_NEAR(seen.center_in_map.x, 7.075, 1e-9);
  EXPECT_NEAR(seen.radius_m, 0.075, 1e-9);
  EXPECT_NEAR(seen.age_s, 2, 1e-9);
  EXPECT_EQ(ObservedObstacleNear(window, ground, obstacles, {5, 6}, 0.5, 3000)
                .radius_m,
            0);
  // No sensor shows them any more.
  EXPECT_TRUE(UnseenObstaclesNear(window, ground, obstacles, {7, 6}, 0.5, 1100)
                  .empty());
  EXPECT_EQ(
      UnseenObstaclesNear(window, ground, obstacles, {7, 6}, 0.5, 3000).size(),
      3u);
}

}  // namespace
}  // namespace treeline::control
