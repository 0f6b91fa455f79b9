#include "nav_agent/bridge/agent_values/laser_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/ros2/conversions/geometry_values.h"

namespace treeline::agent_values {
namespace {

messages::LaserScan Scan() {
  messages::LaserScan scan;
  scan.header.stamp = {3, 500'000'000};
  scan.angle_min = -1;
  scan.angle_increment = 0.5;
  scan.time_increment = 0.001F;
  scan.scan_time = 0.025F;
  scan.range_min = 0.5;
  scan.range_max = 8;
  scan.ranges = {1, 9, 0.25, 0, std::numeric_limits<float>::quiet_NaN()};
  scan.intensities = {1, 2, -3, 70000, 5};
  return scan;
}

TEST(LaserValuesTest, RangesOutsideOfTheLimitsAreNone) {
  const core::LaserScan scan = ScanOf(Scan());
  EXPECT_EQ(scan.stamp, conversions::TimeOf({3, 500'000'000}));
  ASSERT_EQ(scan.ranges_m.size(), 5U);
  EXPECT_EQ(scan.ranges_m[0], 1);
  EXPECT_EQ(scan.ranges_m[1], core::kNoReturn);
  EXPECT_EQ(scan.ranges_m[2], core::kTooNear);
  EXPECT_TRUE(std::isnan(scan.ranges_m[3]));
  EXPECT_TRUE(std::isnan(scan.ranges_m[4]));
  EXPECT_EQ(scan.intensities, (std::vector<uint16_t>{1, 2, 0, 65535, 5}));
}

TEST(LaserValuesTest, InfoComesBackFromItsMessage) {
  const auto info = SensorInfoOf(Scan());
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_EQ(info->beams, 5);
  EXPECT_EQ(info->AngleOf_rad(2), 0);
  const messages::LaserScan again = MessageOf(ScanOf(Scan()), *info, "laser");
  EXPECT_EQ(*SensorInfoOf(again), *info);
  EXPECT_EQ(again.angle_max, 1);
  EXPECT_EQ(again.header.frame_id, "laser");
}

TEST(LaserValuesTest, WhatIsNoLaserIsAnError) {
  messages::LaserScan scan = Scan();
  scan.ranges.clear();
  EXPECT_FALSE(SensorInfoOf(scan).ok());
  scan = Scan();
  scan.angle_increment = 0;
  EXPECT_FALSE(SensorInfoOf(scan).ok());
  scan = Scan();
  scan.range_max = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(SensorInfoOf(scan).ok());
  scan = Scan();
  scan.range_max = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(SensorInfoOf(scan).ok());
  scan = Scan();
  scan.range_max = 0;
  EXPECT_FALSE(SensorInfoOf(scan).ok());
  scan = Scan();
  scan.ranges.resize(10'000'000);
  EXPECT_FALSE(SensorInfoOf(scan).ok());
}

TEST(LaserValuesTest, AnglesInDegreesAreRefused) {
  messages::LaserScan scan = Scan();
  scan.angle_min = -135;
  scan.angle_max = 135;
  scan.angle_increment = 67.5;
  const absl::Status status = SensorInfoOf(scan).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()),
              testing::HasSubstr("are these degrees?"));
  // A whole turn, and a beam more.
  scan.angle_min = -3.14159F;
  scan.angle_increment = 2 * 3.14159F / 4;
  scan.angle_max = 3.14159F;
  EXPECT_TRUE(SensorInfoOf(scan).ok());
}

TEST(LaserValuesTest, BeamsRunAsAngleMaxAndIncrementSay) {
  messages::LaserScan scan = Scan();
  // Clockwise.
  scan.angle_min = 1;
  scan.angle_max = -1;
  scan.angle_increment = -0.5;
  const auto info = SensorInfoOf(scan);
  ASSERT_TRUE(info.ok()) << info.status();
  EXPECT_EQ(info->AngleOf_rad(4), -1);
  scan.angle_increment = 0.5;
  EXPECT_THAT(std::string(SensorInfoOf(scan).status().message()),
              testing::HasSubstr("which way do its beams run?"));
  scan = Scan();
  scan.angle_max = 1;
  scan.angle_increment = -0.5;
  EXPECT_FALSE(SensorInfoOf(scan).ok());
}

TEST(LaserValuesTest, GridsComeBack) {
  core::OccupancyGrid grid = core::OccupancyGrid::Filled(
      3, 2, 0.25, {{1, -2}, 0.5}, core::Occupancy::kFree);
  grid.Set({2, 0}, core::Occupancy::kOccupied);
  grid.Set({0, 1}, core::Occupancy::kUnknown);
  const messages::OccupancyGrid message =
      MessageOf(grid, {.stamp = {1, 2}, .frame_id = "map"});
  EXPECT_EQ(message.data, (std::vector<int8_t>{0, 0, 100, -1, 0, 0}));
  const auto again = GridOf(message);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->cells, grid.cells);
  EXPECT_NEAR(again->map_from_grid.yaw_rad, 0.5, 1e-9);
  EXPECT_EQ(again->map_from_grid.translation, grid.map_from_grid.translation);
}

TEST(LaserValuesTest, GridsThatLieAboutTheirSizeAreErrors) {
  messages::OccupancyGrid grid;
  grid.info.resolution = 0.05F;
  grid.info.width = 1'000'000;
  grid.info.height = 1'000'000;
  EXPECT_FALSE(GridOf(grid).ok());
  grid.info.width = 2;
  grid.info.height = 2;
  grid.data = {0, 0, 0};
  EXPECT_FALSE(GridOf(grid).ok());
}

// A cell's number is a point divided by the resolution.
TEST(LaserValuesTest, GridsOfNoSizeOrFarAwayAreErrors) {
  messages::OccupancyGrid grid;
  grid.info.resolution = 0.05F;
  grid.info.width = 2;
  grid.info.height = 2;
  grid.data = {0, 0, 0, 0};
  EXPECT_TRUE(GridOf(grid).ok());
  grid.info.resolution = 1e-30F;
  EXPECT_FALSE(GridOf(grid).ok());
  grid.info.resolution = 1e30F;
  EXPECT_FALSE(GridOf(grid).ok());
  grid.info.resolution = 0.05F;
  grid.info.origin.position.x = 1e300;
  EXPECT_FALSE(GridOf(grid).ok());
}

}  // namespace
}  // namespace treeline::agent_values
