#include "nav_agent/localization/lost_scan_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gtest/gtest.h"
#include "nav_agent/localization/testing_map.h"

namespace treeline::localization {
namespace {

constexpr geometry::Rigid2 kPlace = {.translation = {0.5, 2.9}, .yaw_rad = 0.4};
const geometry::Rigid3 kBaseFromLaser = {.rotation = {},
                                         .translation = {0, 0, 0.35}};

core::LaserScan CleanScan(const geometry::Rigid2& map_from_laser) {
  base::Random random(1, 1);
  return ScanOf(TestingMap(), TestingLaser(), map_from_laser, 0.01, random);
}

ScanChecker MakeChecker(const LaserMap& map) {
  auto checker = ScanChecker::Create(map, {});
  EXPECT_TRUE(checker.ok()) << checker.status();
  return *std::move(checker);
}

double ShareOf(const std::vector<CheckedBeam>& beams, BeamFit fit) {
  return static_cast<double>(
             std::ranges::count(beams, fit, &CheckedBeam::fit)) /
         static_cast<double>(beams.size());
}

std::vector<CheckedBeam> Check(const ScanPose& pose,
                               const core::LaserScan& scan) {
  const auto beams = MakeChecker(LaserMap::AllOpaque(TestingMap()))
                         .Check(pose, TestingLaser(), kBaseFromLaser, scan);
  EXPECT_TRUE(beams.ok()) << beams.status();
  return *beams;
}

TEST(ScanCheckerTest, AScanFromTheRightPlaceIsExplained) {
  const std::vector<CheckedBeam> beams =
      Check({.map_from_base = kPlace}, CleanScan(kPlace));
  // 120 of the laser's beams, but for those that see past edges.
  EXPECT_GT(beams.size(), 100u);
  EXPECT_GT(ShareOf(beams, BeamFit::kExplained), 0.97);
  EXPECT_EQ(ShareOf(beams, BeamFit::kLong), 0);
}

TEST(ScanCheckerTest, ALittleErrorIsStillExplained) {
  const geometry::Rigid2 nearby = {.translation = {0.56, 2.85},
                                   .yaw_rad = 0.42};
  const std::vector<CheckedBeam> beams =
      Check({.map_from_base = nearby}, CleanScan(kPlace));
  EXPECT_GT(ShareOf(beams, BeamFit::kExplained), 0.95);
}

TEST(ScanCheckerTest, FromAnotherPlaceBeamsPassThroughWalls) {
  const std::vector<CheckedBeam> beams =
      Check({.map_from_base = {.translation = {7, 4}, .yaw_rad = 2}},
            CleanScan(kPlace));
  EXPECT_GT(ShareOf(beams, BeamFit::kLong), 0.2);
  EXPECT_LT(ShareOf(beams, BeamFit::kExplained), 0.6);
}

TEST(ScanCheckerTest, SomebodyBeforeTheRobotIsShort) {
  core::LaserScan scan = CleanScan(kPlace);
  for (size_t i = 80; i < 110; ++i) scan.ranges_m[i] = 0.8f;
  const std::vector<CheckedBeam> beams = Check({.map_from_base = kPlace}, scan);
  // 30 of 181 beams.
  EXPECT_NEAR(ShareOf(beams, BeamFit::kShort), 30.0 / 181, 0.02);
  EXPECT_EQ(ShareOf(beams, BeamFit::kLong), 0);
}

TEST(ScanCheckerTest, WhatIsSeenThroughProvesNothing) {
  LaserMap map = LaserMap::AllOpaque(TestingMap());
  map.opaque = core::OccupancyGrid::Filled(
      map.map.width, map.map.height, map.map.resolution_m,
      map.map.map_from_grid, core::Occupancy::kFree);
  const auto beams = MakeChecker(map).Check(
      {.map_from_base = {.translation = {7, 4}, .yaw_rad = 2}}, TestingLaser(),
      kBaseFromLaser, CleanScan(kPlace));
  ASSERT_TRUE(beams.ok());
  EXPECT_EQ(ShareOf(*beams, BeamFit::kLong), 0);
}

TEST(ScanCheckerTest, ATiltedRobotsBeamsMayEndOnTheGround) {
  // Nose down by 6 degrees, beams ahead meet the ground after 0.35 / tan(6) =
  // 3.3 m: those that end there are not judged.
  core::LaserScan scan = CleanScan(kPlace);
  for (size_t i = 85; i < 96; ++i) scan.ranges_m[i] = 3.3f;
  const double pitch_rad = 6 * 3.14159265 / 180;
  const std::vector<CheckedBeam> beams =
      Check({.map_from_base = kPlace, .pitch_rad = pitch_rad}, scan);
  EXPECT_EQ(ShareOf(beams, BeamFit::kShort), 0);
  const auto points = PointsAtLaserHeight(scan, TestingLaser(), kBaseFromLaser,
                                          pitch_rad, 0, 181, {});
  ASSERT_TRUE(points.ok());
  for (size_t i = 0; i < points->size(); ++i) {
    // sin(6) is 0.1: 0.2 m lower after 2 m ahead.
    EXPECT_LT(points->x_m[i], 2.1);
  }
}

TEST(ScanCheckerTest, RefusesWhatIsNoScanOrNoPose) {
  const ScanChecker checker = MakeChecker(LaserMap::AllOpaque(TestingMap()));
  core::LaserScan scan = CleanScan(kPlace);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(checker
                .Check({.map_from_base = {.translation = {nan, 0}}},
                       TestingLaser(), kBaseFromLaser, scan)
                .status()
                .code(),
            absl::StatusCode::kInvalidArgument);
  scan.ranges_m.pop_back();
  EXPECT_EQ(checker
                .Check({.map_from_base = kPlace}, TestingLaser(),
                       kBaseFromLaser, scan)
                .status()
                .code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(ScanCheckerTest, BeamsWithoutARangeAreLeftOut) {
  core::LaserScan scan = CleanScan(kPlace);
  std::ranges::fill(scan.ranges_m, core::kInvalidRange);
  EXPECT_TRUE(Check({.map_from_base = kPlace}, scan).empty());
}

TEST(ScanCheckerTest, RefusesMapsThatDoNotBelongTogether) {
  LaserMap map = LaserMap::AllOpaque(TestingMap());
  map.opaque.width -= 1;
  EXPECT_EQ(ScanChecker::Create(map, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ScanChecker::Create({}, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::localization
