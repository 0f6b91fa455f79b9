#include "nav_agent/bridge/place_finder/odometry_trail.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/ros2/conversions/geometry_values.h"

namespace treeline::place_finder {
namespace {

messages::Odometry At(double seconds, double x_m, double yaw_rad) {
  messages::Odometry odometry;
  odometry.header = {.stamp = messages::TimeOf(
                         static_cast<int64_t>(std::llround(seconds * 1e9))),
                     .frame_id = "odom"};
  odometry.pose.pose = conversions::PoseOf(
      {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad}),
       .translation = {x_m, 0, 0}});
  return odometry;
}

base::MonotonicTime Moment(double seconds) {
  return conversions::TimeOf(At(seconds, 0, 0).header.stamp);
}

TEST(OdometryTrailTest, LiesBetweenTwoMessages) {
  OdometryTrail trail;
  ASSERT_TRUE(trail.Add(At(100, 1, 3)).ok());
  ASSERT_TRUE(trail.Add(At(101, 2, -3)).ok());
  const auto motion = trail.At(Moment(100.25));
  ASSERT_TRUE(motion.has_value());
  EXPECT_NEAR(motion->odom_from_base.translation.x, 1.25, 1e-9);
  // The short way round.
  EXPECT_NEAR(motion->odom_from_base.yaw_rad, 3 + 0.25 * (2 * M_PI - 6), 1e-9);
  EXPECT_EQ(trail.frame(), "odom");
}

TEST(OdometryTrailTest, KnowsNothingOfOtherTimes) {
  OdometryTrail trail;
  EXPECT_FALSE(trail.At(Moment(100)).has_value());
  ASSERT_TRUE(trail.Add(At(100, 1, 0)).ok());
  EXPECT_FALSE(trail.At(Moment(99.9)).has_value());
  EXPECT_TRUE(trail.At(Moment(100.05)).has_value());
  EXPECT_FALSE(trail.At(Moment(100.5)).has_value());
  ASSERT_TRUE(trail.Add(At(120, 1, 0)).ok());
  EXPECT_FALSE(trail.At(Moment(100)).has_value());
}

TEST(OdometryTrailTest, BeginsAnewWithTheClock) {
  OdometryTrail trail;
  ASSERT_TRUE(trail.Add(At(100, 1, 0)).ok());
  ASSERT_TRUE(trail.Add(At(99.9, 5, 0)).ok());
  EXPECT_EQ(trail.newest().odom_from_base.translation.x, 1);
  ASSERT_TRUE(trail.Add(At(3, 7, 0)).ok());
  EXPECT_EQ(trail.newest().odom_from_base.translation.x, 7);
  EXPECT_FALSE(trail.At(Moment(100)).has_value());
}

TEST(OdometryTrailTest, NumbersThatAreNoneAreErrors) {
  OdometryTrail trail;
  messages::Odometry odometry = At(1, 0, 0);
  odometry.twist.twist.linear.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(trail.Add(odometry).ok());
  EXPECT_TRUE(trail.empty());
}

}  // namespace
}  // namespace treeline::place_finder
