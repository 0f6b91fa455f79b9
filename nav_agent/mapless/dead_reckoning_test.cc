#include "nav_agent/mapless/dead_reckoning.h"

#include <chrono>
#include <numbers>

#include "gtest/gtest.h"

namespace treeline::mapless {
namespace {

base::MonotonicTime At_ms(int milliseconds) {
  return base::MonotonicTime(std::chrono::milliseconds(milliseconds));
}

core::BaseReading Reading(int milliseconds, double wheels_m,
                          double forward_mps = 0, double yaw_rate_radps = 0) {
  core::BaseReading reading;
  reading.stamp = At_ms(milliseconds);
  reading.left_wheel_m = wheels_m;
  reading.right_wheel_m = wheels_m;
  reading.forward_mps = forward_mps;
  reading.yaw_rate_radps = yaw_rate_radps;
  return reading;
}

TEST(DeadReckoning, KnowsNothingBeforeTheFirstReading) {
  DeadReckoning reckoning;
  EXPECT_FALSE(reckoning.Newest().has_value());
  EXPECT_FALSE(reckoning.At(At_ms(0)).has_value());
}

TEST(DeadReckoning, WheelsTellHowFarAndTheGyroscopeWhereTo) {
  DeadReckoning reckoning;
  // A quarter of a circle of 1 m radius, in 100 readings of 10 ms.
  const double turn_radps = std::numbers::pi / 2;
  for (int i = 0; i <= 100; ++i) {
    reckoning.Add(
        Reading(10 * i, 5 + turn_radps * 0.01 * i, turn_radps, turn_radps));
  }
  const geometry::Rigid2 pose = reckoning.Newest()->map_from_base;
  EXPECT_NEAR(pose.translation.x, 1, 1e-3);
  EXPECT_NEAR(pose.translation.y, 1, 1e-3);
  EXPECT_NEAR(pose.yaw_rad, std::numbers::pi / 2, 1e-9);
}

TEST(DeadReckoning, KnowsTheTimesBetweenAndAMomentAhead) {
  DeadReckoning reckoning;
  reckoning.Add(Reading(0, 0, 1));
  reckoning.Add(Reading(10, 0.01, 1));
  reckoning.Add(Reading(20, 0.02, 1));
  EXPECT_NEAR(reckoning.At(At_ms(15))->translation.x, 0.015, 1e-9);
  EXPECT_NEAR(reckoning.At(At_ms(50))->translation.x, 0.05, 1e-9);
  EXPECT_FALSE(reckoning.At(At_ms(500)).has_value());
}

TEST(DeadReckoning, CountersThatBeginAgainMoveNothing) {
  DeadReckoning reckoning;
  reckoning.Add(Reading(0, 100));
  reckoning.Add(Reading(10, 0));
  reckoning.Add(Reading(20, 0.01));
  EXPECT_NEAR(reckoning.Newest()->map_from_base.translation.x, 0.01, 1e-9);
}

TEST(DeadReckoning, IsWhereItIsTold) {
  DeadReckoning reckoning;
  reckoning.Add(Reading(0, 0));
  reckoning.SetPose({{3, 4}, std::numbers::pi / 2});
  reckoning.Add(Reading(10, 0.02));
  const geometry::Rigid2 pose = reckoning.Newest()->map_from_base;
  EXPECT_NEAR(pose.translation.x, 3, 1e-9);
  EXPECT_NEAR(pose.translation.y, 4.02, 1e-9);
}

}  // namespace
}  // namespace treeline::mapless
