#include "nav_agent/control/local_costmap.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "gtest/gtest.h"
#include "nav_agent/control/testing_floor.h"

namespace treeline::control {
namespace {

LocalCostmap MakeCostmap(const TestingFloor& floor,
                         const LocalCostmapOptions& options = {}) {
  return *LocalCostmap::Make(floor.Map(), core::RobotModel(),
                             {.front = TestingLaser()}, options);
}

// So many scans, 25 ms apart, from the same place.
void Look(LocalCostmap& costmap, ControlPose pose, int scans,
          const std::function<bool(geometry::Vec2)>& is_solid,
          double from_s = 0) {
  for (int scan = 0; scan < scans; ++scan) {
    pose.stamp = TestingTime(from_s + 0.025 * scan);
    costmap.MoveTo(pose);
    EXPECT_TRUE(costmap.AddScan(pose, TestingScan(pose, is_solid)).ok());
    costmap.Update(pose.stamp);
  }
}

TEST(LocalCostmap, DistancesAreExactAndDoNotSaturate) {
  // One that is decoded from a cost byte ends near half a metre.
  TestingFloor floor;
  floor.Fill({7.5, 0}, {7.55, 12}, core::Occupancy::kOccupied);
  LocalCostmap costmap = MakeCostmap(floor);
  costmap.MoveTo(TestingPose(6, 6));
  costmap.Update(TestingTime(0));
  // To the cell's near side.
  EXPECT_NEAR(costmap.Distance_m({7.2, 6}), 0.30, 1e-6);
  EXPECT_NEAR(costmap.Distance_m({6.3, 6}), 1.20, 1e-6);
  EXPECT_NEAR(costmap.Distance_m({5.6, 6}), 1.90, 1e-6);
}

TEST(LocalCostmap, UnknownAndOffTheMapAreNotFree) {
  TestingFloor floor;
  floor.Fill({6.5, 0}, {12, 12}, core::Occupancy::kUnknown);
  LocalCostmap costmap = MakeCostmap(floor);
  costmap.MoveTo(TestingPose(5.5, 6));
  costmap.Update(TestingTime(0));
  EXPECT_EQ(costmap.CellAt({7, 6}), LocalCell::kMapObstacle);
  EXPECT_LE(costmap.FootprintDistance_m({.translation = {7, 6}}, 0.5), 0);
  costmap.MoveTo(TestingPose(0.5, 6));
  costmap.Update(TestingTime(0));
  EXPECT_EQ(costmap.CellAt({-0.5, 6}), LocalCell::kMapObstacle);
  EXPECT_LE(costmap.FootprintDistance_m({.translation = {0.1, 6}}, 0.5), 0);
  EXPECT_GT(costmap.FootprintDistance_m({.translation = {0.6, 6}}, 0.5), 0.2);
  // Outside of the window nothing is known.
  EXPECT_LT(costmap.Distance_m({8, 6}), 0);
}

TEST(LocalCostmap, TheFootprintsDistanceDependsOnItsHeading) {
  TestingFloor floor;
  floor.Fill({0, 6.4}, {12, 6.45}, core::Occupancy::kOccupied);
  core::RobotModel robot;
  robot.front_m = 0.6;
  LocalCostmap costmap =
      *LocalCostmap::Make(floor.Map(), robot, {.front = TestingLaser()}, {});
  costmap.MoveTo(TestingPose(6, 6));
  costmap.Update(TestingTime(0));
  EXPECT_NEAR(costmap.FootprintDistance_m({.translation = {6, 6}}, 0.5),
              0.4 - 0.31, 1e-6);
  EXPECT_LT(costmap.FootprintDistance_m(
                {.translation = {6, 6}, .yaw_rad = std::numbers::pi / 2}, 0.5),
            0);
  EXPECT_NEAR(
      costmap.FootprintDistance_m(
          {.translation = {6, 6}, .yaw_rad = -std::numbers::pi / 2}, 0.5),
      0.4 - 0.30, 1e-6);
}

TEST(LocalCostmap, SomethingThinInTheFootprintIsFound) {
  TestingFloor floor;
  floor.Fill({6.2, 6.2}, {6.25, 6.25}, core::Occupancy::kOccupied);
  LocalCostmap costmap = MakeCostmap(floor);
  costmap.MoveTo(TestingPose(6, 5));
  costmap.Update(TestingTime(0));
  EXPECT_LT(costmap.FootprintDistance_m({.translation = {6, 6}}, 0.5), 0);
}

TEST(LocalCostmap, ItTakesSomeScansToMarkAndToClear) {
  LocalCostmap costmap = MakeCostmap(TestingFloor());
  const auto crate = TestingBox({7, 5.8}, {7.4, 6.2});
  const ControlPose pose = TestingPose(6, 6);
  Look(costmap, pose, 2, crate);
  EXPECT_EQ(costmap.CellAt({7.02, 6}), LocalCell::kFree);
  Look(costmap, pose, 2, crate, 0.1);
  EXPECT_EQ(costmap.CellAt({7.02, 6}), LocalCell::kSeen);
  Look(costmap, pose, 20, crate, 0.2);
  // It is gone: within 150 ms the place is free.
  Look(costmap, pose, 6, NothingThere, 1.0);
  EXPECT_EQ(costmap.CellAt({7.02, 6}), LocalCell::kFree);
}

TEST(LocalCostmap, WhatStandsIsRememberedWhileItIsHidden) {
  LocalCostmap costmap = MakeCostmap(TestingFloor());
  const auto crate = TestingBox({7, 5.8}, {7.4, 6.2});
  Look(costmap, TestingPose(6, 6), 60, crate);
  // The robot turns its back on it.
  Look(costmap, TestingPose(6, 6, std::numbers::pi), 10, NothingThere, 10);
  EXPECT_EQ(costmap.CellAt({7.02, 6}), LocalCell::kSeen);
  costmap.ClearObstacles();
  EXPECT_EQ(costmap.CellAt({7.02, 6}), LocalCell::kFree);
}

TEST(LocalCostmap, SomebodyWhoLeftTheViewIsForgotten) {
  LocalCostmap costmap = MakeCostmap(TestingFloor());
  const ControlPose pose = TestingPose(6, 6);
  Look(costmap, pose, 20, NothingThere);
  Look(costmap, pose, 6, TestingBox({7, 5.8}, {7.4, 6.2}), 0.5);
  EXPECT_EQ(costmap.CellAt({7.02, 6}), LocalCell::kSeen);
  ControlPose turned = TestingPose(6, 6, std::numbers::pi);
  Look(costmap, turned, 2, NothingThere, 1.0);
  EXPECT_EQ(costmap.CellAt({7.02, 6}), LocalCell::kSeen);
  Look(costmap, turned, 2, NothingThere, 4.0);
  EXPECT_EQ(costmap.CellAt({7.02, 6}), LocalCell::kFree);
}

TEST(LocalCostmap, WhatComesWhereItWasFreeMoves) {
  LocalCostmap costmap = MakeCostmap(TestingFloor());
  const ControlPose pose = TestingPose(6, 6);
  const auto moving_points = [&costmap] {
    return std::ranges::count_if(costmap.scan_points(),
                                 &ObservedPoint::is_moving);
  };
  const auto crate = TestingBox({7, 5.8}, {7.4, 6.2});
  // There from the first scan on: it stands.
  Look(costmap, pose, 10, crate);
  EXPECT_GT(costmap.scan_points().size(), 10u);
  EXPECT_EQ(moving_points(), 0);
  // It comes nearer.
  Look(costmap, pose, 3, TestingBox({6.8, 5.8}, {7.2, 6.2}), 0.5);
  EXPECT_GT(moving_points(), 10);
  Look(costmap, pose, 60, TestingBox({6.8, 5.8}, {7.2, 6.2}), 0.6);
  EXPECT_EQ(moving_points(), 0);
}

TEST(LocalCostmap, GlassOfTheMapCountsThoughLasersLookThroughIt) {
  TestingFloor floor;
  floor.Fill({7, 0}, {7.05, 12}, core::Occupancy::kOccupied);
  LocalCostmap costmap = MakeCostmap(floor);
  Look(costmap, TestingPose(6, 6), 40, NothingThere);
  EXPECT_EQ(costmap.CellAt({7.02, 6}), LocalCell::kMapObstacle);
}

TEST(LocalCostmap, ARampAheadIsFreeAndACrateOnItIsNot) {
  TestingFloor floor;
  floor.Ramp({6.5, 0}, {12, 12}, 0.3);
  LocalCostmap costmap = MakeCostmap(floor);
  // The laser, 0.35 m above the floor, meets the ramp 1.17 m behind its foot.
  const auto ramp = TestingBox({6.5 + 0.35 / 0.3, 0}, {12, 12});
  Look(costmap, TestingPose(6, 6), 20, ramp);
  EXPECT_EQ(costmap.CellAt({7.70, 6}), LocalCell::kFree);
  EXPECT_EQ(costmap.CellAt({7.75, 6}), LocalCell::kFree);
  EXPECT_EQ(costmap.GroundAt({7.72, 6})->height_m > 0.3, true);
  // 0.15 m above the ramp's ground something stands.
  const auto crate = TestingBox({7.15, 5.8}, {7.5, 6.2});
  Look(costmap, TestingPose(6, 6), 20, crate, 1.0);
  EXPECT_EQ(costmap.CellAt({7.17, 6}), LocalCell::kSeen);
}

TEST(LocalCostmap, ARobotThatLeansSeesTheFloor) {
  LocalCostmap costmap = MakeCostmap(TestingFloor());
  ControlPose pose = TestingPose(6, 6);
  // 8 degrees nose down: beams ahead end on the floor after 2.3 m; 0.8 m of
  // the window lie behind that.
  pose.level_from_base = geometry::Rotation3::FromAxisAngle({0, 0.2, 0});
  const auto floor = [](geometry::Vec2 at) { return at.x > 7.72; };
  Look(costmap, pose, 10, floor);
  EXPECT_EQ(costmap.CellAt({7.74, 6}), LocalCell::kFree);
}

TEST(LocalCostmap, GroundGoesOnOverAJoinAndNotOverADrop) {
  TestingFloor floor;
  // A ramp up along x at y in [5, 7], a platform at its end; beside it, floor.
  floor.Ramp({6, 5}, {7, 7}, 0.25).Raise({7, 4}, {12, 8}, 0.25);
  traversability::TraversableMap map;
  map.levels.push_back(floor.level());
  // The platform's upper part is another level.
  map.levels.push_back(floor.level());
  for (size_t i = 0; i < map.levels[0].height_m.size(); ++i) {
    const bool is_high = map.levels[0].height_m[i] > 0.11F;
    const size_t without = is_high ? 0 : 1;
    map.levels[without].height_m[i] = std::numeric_limits<float>::quiet_NaN();
    map.levels[without].grid.cells[i] = core::Occupancy::kUnknown;
  }
  LocalCostmap costmap =
      *LocalCostmap::Make(std::make_shared<const traversability::NavigationMap>(
                              *traversability::NavigationMap::Make(map)),
                          core::RobotModel(), {.front = TestingLaser()}, {});
  costmap.MoveTo(TestingPose(6.2, 6));
  costmap.Update(TestingTime(0));
  ASSERT_TRUE(costmap.GroundAt({7.5, 6}).has_value());
  EXPECT_EQ(costmap.GroundAt({7.5, 6})->level, 1);
  EXPECT_NEAR(costmap.GroundAt({7.5, 6})->height_m, 0.25, 1e-6);
  EXPECT_EQ(costmap.CellAt({6.8, 6}), LocalCell::kFree);
  // Of a robot on a raised piece of floor, what is around it is a drop.
  TestingFloor island;
  island.Raise({5, 5}, {7, 7}, 0.5);
  LocalCostmap on_top = MakeCostmap(island);
  ControlPose pose = TestingPose(6, 6);
  pose.pose.place.height_m = 0.5;
  on_top.MoveTo(pose);
  on_top.Update(TestingTime(0));
  EXPECT_EQ(on_top.CellAt({6.9, 6}), LocalCell::kFree);
  EXPECT_EQ(on_top.CellAt({7.1, 6}), LocalCell::kMapObstacle);
}

TEST(LocalCostmap, ALostRobotDoesNotAskTheMap) {
  TestingFloor floor;
  floor.Fill({0, 0}, {12, 12}, core::Occupancy::kOccupied)
      .Fill({1, 1}, {2, 2}, core::Occupancy::kFree);
  LocalCostmap costmap = MakeCostmap(floor);
  ControlPose pose = TestingPose(6, 6);
  pose.map_is_unknown = true;
  Look(costmap, pose, 20, TestingBox({7, 5.8}, {7.4, 6.2}));
  EXPECT_EQ(costmap.CellAt({6.5, 6}), LocalCell::kFree);
  EXPECT_EQ(costmap.CellAt({7.02, 6}), LocalCell::kSeen);
  // Nor does it take a wall for a person, who is wider than he looks.
  ASSERT_FALSE(costmap.scan_points().empty());
  EXPECT_FALSE(costmap.scan_points().front().is_new);
  EXPECT_NEAR(costmap.Distance_m({6.5, 6}), 0.5, 0.05);
  pose.map_is_unknown = false;
  costmap.MoveTo(pose);
  costmap.Update(pose.stamp);
  EXPECT_EQ(costmap.CellAt({6.5, 6}), LocalCell::kMapObstacle);
}

TEST(LocalCostmap, ALostRobotOnARampSeesTheRampAsGround) {
  LocalCostmap costmap = MakeCostmap(TestingFloor());
  ControlPose pose = TestingPose(6, 6);
  pose.map_is_unknown = true;
  costmap.MoveTo(pose);
  EXPECT_EQ(costmap.GroundAt({7.5, 6})->height_m, 0);
  // Nose up by 0.1 rad, where it stands: uphill is ahead.
  pose.level_from_base = geometry::Rotation3::FromAxisAngle({0, -0.1, 0});
  costmap.MoveTo(pose);
  EXPECT_NEAR(costmap.GroundAt({7.5, 6})->height_m, 0.15, 0.005);
  EXPECT_NEAR(costmap.GroundAt({7.5, 7})->height_m, 0.15, 0.005);
  // What is behind may be lower; it is no obstacle either way.
  EXPECT_EQ(costmap.GroundAt({4.5, 6})->height_m, 0);
  // To the left, for a robot that has turned.
  pose.pose.map_from_base.yaw_rad = std::numbers::pi / 2;
  costmap.MoveTo(pose);
  EXPECT_NEAR(costmap.GroundAt({6, 7.5})->height_m, 0.15, 0.005);
  EXPECT_NEAR(costmap.GroundAt({7.5, 6})->height_m, 0, 0.005);
}

// A camera 1 m high that looks straight down from 1 m before the base sees the
// floor, and a box of this height in the middle of the picture.
core::RgbdFrame DepthOfBox(double box_m, base::MonotonicTime stamp) {
  core::RgbdFrame frame;
  frame.stamp = stamp;
  frame.frame.calibration = camera::RgbdCalibration();
  frame.frame.calibration->color =
      *camera::Camera::Create(camera::CameraModel::kPinhole, 64, 48,
                              std::array<double, 4>{60, 60, 32, 24}.data(), 4);
  frame.frame.calibration->depth = frame.frame.calibration->color;
  image::DepthImage depth = {.width = 64, .height = 48, .values = {}};
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool is_box = std::abs(x - 32) < 8 && std::abs(y - 24) < 8;
      depth.values.push_back(
          static_cast<uint16_t>(1000 * (is_box ? 1 - box_m : 1.0)));
    }
  }
  frame.frame.depth = depth;
  return frame;
}

TEST(LocalCostmap, DepthMarksAndClearsWhatIsLowerThanTheLaser) {
  core::RobotModel robot;
  robot.base_from_camera =
      core::RobotModel::UprightCamera({1.0, 0, 1.0}, std::numbers::pi / 2);
  LocalCostmap costmap = *LocalCostmap::Make(TestingFloor().Map(), robot,
                                             {.front = TestingLaser()}, {});
  ControlPose pose = TestingPose(6, 6);
  costmap.MoveTo(pose);
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(costmap.AddDepth(pose, DepthOfBox(0.2, pose.stamp)).ok());
  }
  costmap.Update(pose.stamp);
  EXPECT_EQ(costmap.CellAt({7, 6}), LocalCell::kSeen);
  EXPECT_FALSE(costmap.depth_points().empty());
  // A laser looks over it and takes nothing back; depth does.
  Look(costmap, pose, 10, NothingThere, 0.1);
  EXPECT_EQ(costmap.CellAt({7, 6}), LocalCell::kSeen);
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(costmap.AddDepth(pose, DepthOfBox(0.0, pose.stamp)).ok());
  }
  costmap.Update(pose.stamp);
  EXPECT_EQ(costmap.CellAt({7, 6}), LocalCell::kFree);
}

TEST(LocalCostmap, WhoComesToWhereTheCameraSawSomethingMoves) {
  core::RobotModel robot;
  robot.base_from_camera =
      core::RobotModel::UprightCamera({1.0, 0, 1.0}, std::numbers::pi / 2);
  LocalCostmap costmap = *LocalCostmap::Make(TestingFloor().Map(), robot,
                                             {.front = TestingLaser()}, {});
  // For 2 s there is a box, which the laser looks over.
  for (int i = 0; i < 10; ++i) {
    ControlPose pose = TestingPose(6, 6);
    Look(costmap, pose, 8, NothingThere, 0.2 * i);
    pose.stamp = TestingTime(0.2 * i + 0.19);
    ASSERT_TRUE(costmap.AddDepth(pose, DepthOfBox(0.2, pose.stamp)).ok());
  }
  // A second later somebody steps there.
  Look(costmap, TestingPose(6, 6), 20, NothingThere, 2.5);
  Look(costmap, TestingPose(6, 6), 3, TestingBox({6.9, 5.8}, {7.3, 6.2}), 3.0);
  const auto moving =
      std::ranges::count_if(costmap.scan_points(), &ObservedPoint::is_moving);
  EXPECT_GT(moving, 10);
  EXPECT_EQ(static_cast<size_t>(moving), costmap.scan_points().size());
}

TEST(LocalCostmap, BadInputIsSaid) {
  LocalCostmap costmap = MakeCostmap(TestingFloor());
  const ControlPose pose = TestingPose(6, 6);
  core::LaserScan short_scan = TestingScan(pose, NothingThere);
  short_scan.ranges_m.pop_back();
  EXPECT_EQ(costmap.AddScan(pose, short_scan).code(),
            absl::StatusCode::kInvalidArgument);
  ControlPose nowhere = pose;
  nowhere.pose.map_from_base.translation.x = std::nan("");
  EXPECT_FALSE(costmap.AddScan(nowhere, TestingScan(pose, NothingThere)).ok());
  EXPECT_FALSE(costmap.AddDepth(pose, core::RgbdFrame()).ok());
  EXPECT_FALSE(LocalCostmap::Make(nullptr, core::RobotModel(),
                                  {.front = TestingLaser()}, {})
                   .ok());
  LocalCostmapOptions options;
  options.resolution_m = 0;
  EXPECT_FALSE(LocalCostmap::Make(TestingFloor().Map(), core::RobotModel(),
                                  {.front = TestingLaser()}, options)
                   .ok());
  // Ranges that are none mark nothing.
  core::LaserScan nothing = TestingScan(pose, NothingThere);
  std::ranges::fill(nothing.ranges_m, core::kInvalidRange);
  EXPECT_TRUE(costmap.AddScan(pose, nothing).ok());
  EXPECT_TRUE(costmap.scan_points().empty());
}

}  // namespace
}  // namespace treeline::control
