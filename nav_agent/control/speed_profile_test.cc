// Speeds along a track, and each regulator of them alone.
#include "nav_agent/control/speed_profile.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/control/braking_regulator.h"
#include "nav_agent/control/clearance_regulator.h"
#include "nav_agent/control/corner_regulator.h"
#include "nav_agent/control/curvature_regulator.h"
#include "nav_agent/control/slope_regulator.h"
#include "nav_agent/control/zone_regulator.h"

namespace treeline::control {
namespace {

const core::RobotModel kRobot;

std::vector<TrackPoint> StraightTrack(double length_m, double clearance_m) {
  std::vector<TrackPoint> track;
  for (int i = 0; i * 0.05 <= length_m + 1e-9; ++i) {
    track.push_back({.in_map = {0.05 * i, 0}, .clearance_m = clearance_m});
  }
  return track;
}

// 1 m ahead, 1 m to the left.
std::vector<TrackPoint> RightAngle() {
  std::vector<TrackPoint> corner = StraightTrack(1, 1);
  for (int i = 1; i <= 20; ++i) {
    corner.push_back({.in_map = {1, 0.05 * i}, .clearance_m = 1});
  }
  return corner;
}

TEST(ClearanceRegulator, IsSlowBesideObstacles) {
  const ClearanceRegulator regulator;
  EXPECT_NEAR(regulator.Regulated(0.6, {.clearance_m = 0.05}),
              0.15 + 1.2 * 0.05, 1e-9);
  EXPECT_NEAR(regulator.Regulated(0.6, {.clearance_m = -1}), 0.15, 1e-9);
  EXPECT_EQ(regulator.Regulated(0.6, {.clearance_m = 1}), 0.6);
}

TEST(CurvatureRegulator, IsAsFastAsItCanTurn) {
  const CurvatureRegulator regulator = {.max_yaw_rate_radps = 1};
  EXPECT_EQ(regulator.Regulated(0.6, {.curvature_per_m = 4}), 0.25);
  EXPECT_EQ(regulator.Regulated(0.6, {.curvature_per_m = 1}), 0.6);
  EXPECT_EQ(regulator.Regulated(0.6, {.curvature_per_m = 0}), 0.6);
}

TEST(CornerRegulator, CreepsToWhereItTurnsOnTheSpot) {
  const CornerRegulator regulator;
  EXPECT_NEAR(regulator.Regulated(0.6, {.turn_rad = 1.5}), 0.075, 1e-9);
  EXPECT_EQ(regulator.Regulated(0.6, {.turn_rad = 0.8}), 0.6);
}

TEST(SlopeRegulator, LosesHalfOnTheSteepestSlope) {
  const SlopeRegulator regulator = {.max_slope_rad = 0.28};
  EXPECT_NEAR(regulator.Regulated(0.6, {.slope_rad = 0.28}), 0.3, 1e-9);
  EXPECT_NEAR(regulator.Regulated(0.6, {.slope_rad = 0.14}), 0.45, 1e-9);
  EXPECT_EQ(regulator.Regulated(0.6, {.slope_rad = 0}), 0.6);
}

TEST(ZoneRegulator, IsTheLowestLimit) {
  EXPECT_EQ(ZoneRegulator().Regulated(0.6, {.max_mps = 0.2}), 0.2);
  EXPECT_EQ(ZoneRegulator().Regulated(0.1, {.max_mps = 0.2}), 0.1);
  EXPECT_EQ(ZoneRegulator().Regulated(0.6, {}), 0.6);
}

TEST(BrakingRegulator, IsInTimeForTheNextPoint) {
  const BrakingRegulator regulator = {.deceleration_mps2 = 1};
  EXPECT_NEAR(regulator.Regulated(2, 0, 0.5), 1, 1e-9);
  EXPECT_EQ(regulator.Regulated(0.4, 0, 0.5), 0.4);
}

TEST(SpeedProfile, IsATrapezoidThatEndsInTime) {
  const auto speeds = SpeedProfile(StraightTrack(2, 1), 0, kRobot, {});
  EXPECT_EQ(speeds.front(), 0.6);
  EXPECT_EQ(speeds.back(), 0);
  const double brake = kAccelerationShare * 1.5;
  for (size_t i = 1; i < speeds.size(); ++i) {
    const double left_m = 2 - 0.05 * static_cast<double>(i);
    EXPECT_NEAR(speeds[i], std::min(0.6, std::sqrt(2 * brake * left_m)), 1e-6);
  }
}

TEST(SpeedProfile, IsSlowBesideObstaclesInCurvesAndOnSlopes) {
  EXPECT_NEAR(SpeedProfile(StraightTrack(2, 0.05), 0, kRobot, {}).front(),
              0.15 + 1.2 * 0.05, 1e-9);
  std::vector<TrackPoint> slope = StraightTrack(2, 1);
  for (TrackPoint& point : slope) point.slope_rad = 0.14;
  EXPECT_NEAR(SpeedProfile(slope, 0, kRobot, {}).front(), 0.6 * 0.75, 1e-3);
  // It brakes before a zone, and is as slow as that within.
  std::vector<TrackPoint> zone = StraightTrack(2, 1);
  for (size_t i = 20; i < zone.size(); ++i) zone[i].max_mps = 0.2;
  const auto slow = SpeedProfile(zone, 0.2, kRobot, {});
  EXPECT_EQ(slow[0], 0.6);
  EXPECT_LT(slow[18], 0.5);
  EXPECT_EQ(slow[20], 0.2);
  const auto speeds = SpeedProfile(RightAngle(), 0, kRobot, {});
  EXPECT_LT(speeds[20], 0.1);
  EXPECT_EQ(speeds[0], 0.6);
}

TEST(SpeedProfile, WithoutItsRegulatorsItIsTheHighestSpeed) {
  std::vector<TrackPoint> track = RightAngle();
  for (TrackPoint& point : track) {
    point.clearance_m = 0;
    point.slope_rad = 0.28;
  }
  SpeedProfileOptions options;
  options.switches = {.clearance = false,
                      .curvature = false,
                      .corner = false,
                      .slope = false,
                      .zone = false,
                      .braking = false};
  for (const double speed : SpeedProfile(track, 0, kRobot, options)) {
    EXPECT_EQ(speed, 0.6);
  }
  options.switches.slope = true;
  EXPECT_NEAR(SpeedProfile(track, 0, kRobot, options).front(), 0.3, 1e-9);
}

}  // namespace
}  // namespace treeline::control
