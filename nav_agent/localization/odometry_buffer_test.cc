#include "nav_agent/localization/odometry_buffer.h"

#include <chrono>

#include "gtest/gtest.h"

namespace treeline::localization {
namespace {

base::MonotonicTime At_ms(int ms) {
  return base::MonotonicTime() + std::chrono::milliseconds(ms);
}

// Straight ahead at 1 m/s for so long, a reading each 10 ms.
OdometryBuffer Driven(int ms) {
  OdometryBuffer history(*core::SlopeOdometry::Create({.wheel_track_m = 0.54}));
  for (int at = 0; at <= ms; at += 10) {
    core::BaseReading reading;
    reading.stamp = At_ms(at);
    reading.left_wheel_m = 0.001 * at;
    reading.right_wheel_m = 0.001 * at;
    reading.forward_mps = 1;
    EXPECT_TRUE(history.Add(reading).ok());
  }
  return history;
}

TEST(OdometryBuffer, IsEmptyUntilTheWheelsAreHeard) {
  const OdometryBuffer history(
      *core::SlopeOdometry::Create({.wheel_track_m = 0.54}));
  EXPECT_TRUE(history.is_empty());
  EXPECT_FALSE(history.At(At_ms(0)).has_value());
}

TEST(OdometryBuffer, BetweenReadingsTheRobotMovedEvenly) {
  const OdometryBuffer history = Driven(1000);
  const auto moment = history.At(At_ms(503));
  ASSERT_TRUE(moment.has_value());
  EXPECT_NEAR(moment->motion.odom_from_base.translation.x, 0.503, 1e-9);
  EXPECT_EQ(moment->motion.stamp, At_ms(503));
  EXPECT_EQ(moment->motion.forward_mps, 1);
}

TEST(OdometryBuffer, RemembersTwoAndAHalfSeconds) {
  const OdometryBuffer history = Driven(5000);
  EXPECT_FALSE(history.At(At_ms(2490)).has_value());
  EXPECT_TRUE(history.At(At_ms(2510)).has_value());
}

TEST(OdometryBuffer, WhatIsALittleNewerIsTheNewest) {
  const OdometryBuffer history = Driven(1000);
  ASSERT_TRUE(history.At(At_ms(1044)).has_value());
  EXPECT_NEAR(history.At(At_ms(1044))->motion.odom_from_base.translation.x, 1,
              1e-9);
  EXPECT_FALSE(history.At(At_ms(1046)).has_value());
}

}  // namespace
}  // namespace treeline::localization
