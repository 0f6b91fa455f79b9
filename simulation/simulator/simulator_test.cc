#include "simulation/simulator/simulator.h"

#include <cmath>
#include <numbers>

#include "gtest/gtest.h"
#include "nav_agent/core/robot_file.h"
#include "simulation/simulator/testing_simulator.h"

namespace treeline::simulator {
namespace {

using std::chrono::milliseconds;

constexpr double kPi = std::numbers::pi;

TEST(Simulator, DrivesStraightAndStopsWithinItsLimits) {
  const auto simulator = MakeSimulator(Hall().Build(), StartAt(5, 5));
  Drive(*simulator, {.forward_mps = 0.5}, 4);
  // 0.5 m/s is reached after 0.625 s at 0.8 m/s^2, one step more or less.
  EXPECT_NEAR(PositionOf(*simulator).x, 5 + 0.5 * 4 - 0.5 * 0.625 * 0.5, 0.005);
  EXPECT_NEAR(PositionOf(*simulator).y, 5, 1e-9);
  EXPECT_NEAR(simulator->state().forward_mps, 0.5, 1e-9);
  Drive(*simulator, {}, 1);
  EXPECT_EQ(simulator->state().forward_mps, 0);
  EXPECT_TRUE(simulator->TakeEvents().empty());
}

TEST(Simulator, ArcsAreExact) {
  const auto simulator = MakeSimulator(Hall().Build(), StartAt(10, 10));
  // Up to speed, and then a whole round about a centre 1 m to the left.
  Drive(*simulator, {.forward_mps = 0.5, .yaw_rate_radps = 0.5}, 3);
  const geometry::Rigid3 before = simulator->state().world_from_base;
  const double round_s = 2 * kPi / 0.5;
  Drive(*simulator, {.forward_mps = 0.5, .yaw_rate_radps = 0.5}, 12.5);
  const geometry::Rigid3 after = simulator->state().world_from_base;
  const double rest_rad = (round_s - 12.5) * 0.5;
  const geometry::Vec3 center = before * geometry::Vec3{0, 1, 0};
  EXPECT_NEAR(Norm(after.translation - center), 1, 1e-9);
  EXPECT_NEAR(geometry::AngleBetween_rad(after.rotation, before.rotation),
              rest_rad, 1e-9);
}

TEST(Simulator, ObeysNoCommandForLongerThanItsLifetime) {
  const auto simulator = MakeSimulator(Hall().Build(), StartAt(5, 5));
  Drive(*simulator, {.forward_mps = 0.5}, 2);
  ASSERT_TRUE(simulator->base().SetVelocity({.forward_mps = 0.5}).ok());
  simulator->Step(milliseconds(300));
  EXPECT_NEAR(simulator->state().forward_mps, 0.5, 1e-9);
  simulator->Step(milliseconds(10));
  EXPECT_LT(simulator->state().forward_mps, 0.5);
  simulator->Step(milliseconds(500));
  EXPECT_EQ(simulator->state().forward_mps, 0);
}

TEST(Simulator, StandsOnARampAsGeometrySays) {
  // 1:10 along x, from x = 4 to 14.
  const double slope_rad = std::atan(0.1);
  const double yaw_rad = 0.7;
  PlaceBuilder place;
  place.Floor(0, 0, 4, 20, 0).Ramp(4, 0, 14, 20, 0, 1).Floor(14, 0, 20, 20, 1);
  const auto simulator =
      MakeSimulator(place.Build(), StartAt(8, 8, yaw_rad, 0.4));
  const geometry::Rigid3 world_from_base = simulator->state().world_from_base;
  EXPECT_NEAR(world_from_base.translation.z, 0.4, 1e-6);
  const geometry::Vec3 up = world_from_base.rotation * geometry::Vec3{0, 0, 1};
  const geometry::Vec3 normal = {-std::sin(slope_rad), 0, std::cos(slope_rad)};
  // Floats in the world's corners: a micrometre in half a metre.
  EXPECT_LT(Norm(up - normal), 1e-5);
  simulator->Step(milliseconds(20));
  const std::vector<core::BaseReading> readings =
      simulator->odometry().TakeReadings();
  ASSERT_FALSE(readings.empty());
  // Uphill is nose up; the right side is down when turned to the left of it.
  EXPECT_NEAR(readings.back().pitch_rad,
              -std::atan(std::tan(slope_rad) * std::cos(yaw_rad)), 1e-5);
  EXPECT_LT(readings.back().roll_rad, 0);
}

TEST(Simulator, ClimbsARampAndComesDownAgain) {
  PlaceBuilder place;
  place.Floor(0, 0, 4, 20, 0)
      .Ramp(4, 0, 10, 20, 0, 0.5)
      .Floor(10, 0, 20, 20, 0.5f);
  const auto simulator = MakeSimulator(place.Build(), StartAt(3, 5));
  Drive(*simulator, {.forward_mps = 0.8}, 12);
  EXPECT_NEAR(PositionOf(*simulator).z, 0.5, 1e-6);
  EXPECT_GT(PositionOf(*simulator).x, 11);
  Drive(*simulator, {.yaw_rate_radps = 1}, 4);
  EXPECT_TRUE(simulator->TakeEvents().empty());
}

// It climbs steps of 5 mm, its wheels are small, and most of it is behind them.
TEST(Simulator, ASmallRobotDrivesOverBothEndsOfARamp) {
  for (const double forward_mps : {0.2, -0.2}) {
    PlaceBuilder place;
    place.Floor(0, 0, 4, 20, 0)
        .Ramp(4, 0, 8, 20, 0, 0.5)
        .Floor(8, 0, 20, 20, 0.5f);
    SimulatorOptions options =
        forward_mps > 0 ? StartAt(3.5, 5) : StartAt(8.5, 5, 0, 0.5);
    options.robot = core::ReadRobot("turtlebot3")->model;
    const auto simulator = MakeSimulator(place.Build(), options);
    Drive(*simulator, {.forward_mps = forward_mps}, 26);
    EXPECT_TRUE(simulator->TakeEvents().empty()) << forward_mps;
    EXPECT_NEAR(PositionOf(*simulator).z, forward_mps > 0 ? 0.5 : 0, 1e-6);
  }
}

TEST(Simulator, StopsAtAWallWithTheFootprintTouchingIt) {
  const auto simulator = MakeSimulator(Hall().Build(), StartAt(18, 5));
  Drive(*simulator, {.forward_mps = 0.8}, 4);
  const double front_m = PositionOf(*simulator).x + core::RobotModel().front_m;
  EXPECT_LE(front_m, 20);
  EXPECT_GT(front_m, 19.99);
  EXPECT_TRUE(simulator->state().is_blocked);
  const auto hits = EventsOf(*simulator, SimEventKind::kCollision);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].what, "wall");
  EXPECT_TRUE(hits[0].caused_by_robot);
  EXPECT_NEAR(hits[0].point_in_world.x, 20, 1e-6);
  // Backwards it can go, and then hits it again.
  Drive(*simulator, {.forward_mps = -0.3}, 3);
  EXPECT_LT(PositionOf(*simulator).x, 19.2);
  Drive(*simulator, {.forward_mps = 0.5}, 4);
  EXPECT_EQ(EventsOf(*simulator, SimEventKind::kCollision).size(), 1u);
}

TEST(Simulator, FallsOffAnEdgeAndLiesUntilItIsPutBack) {
  PlaceBuilder place;
  place.Floor(0, 0, 20, 20, 0).Floor(2, 2, 6, 6, 0.8f);
  const auto simulator = MakeSimulator(place.Build(), StartAt(4, 4, 0, 0.8));
  Drive(*simulator, {.forward_mps = 0.5}, 8);
  const auto falls = EventsOf(*simulator, SimEventKind::kFall);
  ASSERT_EQ(falls.size(), 1u);
  EXPECT_NEAR(falls[0].point_in_world.x, 6, 0.01);
  EXPECT_TRUE(simulator->state().is_fallen);
  const geometry::Vec3 where = PositionOf(*simulator);
  Drive(*simulator, {.forward_mps = -0.3}, 2);
  EXPECT_EQ(PositionOf(*simulator), where);
  ASSERT_TRUE(simulator->Kidnap({.position = {10, 10}}).ok());
  EXPECT_FALSE(simulator->state().is_fallen);
  Drive(*simulator, {.forward_mps = 0.5}, 2);
  EXPECT_GT(PositionOf(*simulator).x, 10.5);
}

TEST(Simulator, EnteringStairsIsAFailureOfItsOwn) {
  PlaceBuilder place;
  place.Floor(0, 0, 20, 20, 0).Floor(2, 2, 6, 6, 0.51f);
  place.Box(worlds::SurfaceKind::kStair, {6, 2, 0}, {6.3f, 6, 0.34f})
      .Box(worlds::SurfaceKind::kStair, {6.3f, 2, 0}, {6.6f, 6, 0.17f});
  const auto simulator = MakeSimulator(place.Build(), StartAt(4, 4, 0, 0.5));
  Drive(*simulator, {.forward_mps = 0.5}, 6);
  EXPECT_EQ(EventsOf(*simulator, SimEventKind::kStairs).size(), 1u);
  // From below, they are something to run into.
  ASSERT_TRUE(simulator->Kidnap({.position = {9, 4}, .yaw_rad = kPi}).ok());
  Drive(*simulator, {.forward_mps = 0.5}, 6);
  const auto hits = EventsOf(*simulator, SimEventKind::kCollision);
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].what, "stairs");
}

}  // namespace
}  // namespace treeline::simulator
