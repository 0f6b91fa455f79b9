#include "nav_agent/bridge/robot_ports/odometry_port.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/ros2/conversions/geometry_values.h"
#include "nav_agent/bridge/robot_ports/testing_ports.h"

namespace treeline::robot_ports {
namespace {

constexpr double kTrack_m = 0.5;

class OdometryPortTest : public ::testing::Test {
 protected:
  messages::Odometry At(const geometry::Rigid2& pose, double pitch_rad = 0) {
    testing_.real.Pass(0.02);
    messages::Odometry message;
    message.header = {.stamp = testing_.Stamp(), .frame_id = "odom"};
    message.child_frame_id = "base_footprint";
    message.pose.pose = conversions::PoseOf(
        {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, pose.yaw_rad}) *
                     geometry::Rotation3::FromAxisAngle({0, pitch_rad, 0}),
         .translation = {pose.translation.x, pose.translation.y, 0}});
    return message;
  }
  core::BaseReading Last() { return port_.TakeReadings().back(); }

  TestingTime testing_;
  OdometryPort port_{"odom", kTrack_m, testing_.time, testing_.real};
};

TEST_F(OdometryPortTest, WheelsRollAsThePosesSay) {
  // An arc of 1 m radius to the left, in steps of 0.02 rad, from somewhere.
  const geometry::Rigid2 start = {{5, -2}, 2};
  for (int i = 0; i <= 50; ++i) {
    const double turn_rad = 0.02 * i;
    const geometry::Rigid2 arc = {{std::sin(turn_rad), 1 - std::cos(turn_rad)},
                                  turn_rad};
    messages::Odometry message = At(start * arc);
    message.twist.twist.linear.x = 1;
    message.twist.twist.angular.z = 1;
    ASSERT_TRUE(port_.Add(message, {}).ok());
  }
  const core::BaseReading reading = Last();
  // The chord is shorter than the arc by a part in 24 / 0.02^2.
  EXPECT_NEAR(reading.left_wheel_m, 1 - kTrack_m / 2, 1e-4);
  EXPECT_NEAR(reading.right_wheel_m, 1 + kTrack_m / 2, 1e-4);
  EXPECT_EQ(reading.forward_mps, 1);
  EXPECT_EQ(reading.yaw_rate_radps, 1);
  EXPECT_EQ(reading.stamp, testing_.real.Now());
}

TEST_F(OdometryPortTest, BackwardIsBackward) {
  ASSERT_TRUE(port_.Add(At({{0, 0}, 1}), {}).ok());
  ASSERT_TRUE(
      port_.Add(At({{-0.01 * std::cos(1), -0.01 * std::sin(1)}, 1}), {}).ok());
  const core::BaseReading reading = Last();
  EXPECT_NEAR(reading.left_wheel_m, -0.01, 1e-9);
  EXPECT_NEAR(reading.right_wheel_m, -0.01, 1e-9);
}

TEST_F(OdometryPortTest, PitchAndWayOnASlope) {
  // Nose up by 0.1 rad.
  ASSERT_TRUE(port_.Add(At({{0, 0}, 0}, -0.1), {}).ok());
  messages::Odometry up = At({{0.01 * std::cos(0.1), 0}, 0}, -0.1);
  up.pose.pose.position.z = 0.01 * std::sin(0.1);
  ASSERT_TRUE(port_.Add(up, {}).ok());
  const core::BaseReading reading = Last();
  EXPECT_NEAR(reading.pitch_rad, -0.1, 1e-9);
  EXPECT_NEAR(reading.roll_rad, 0, 1e-9);
  EXPECT_NEAR(reading.left_wheel_m, 0.01, 1e-9);
}

TEST_F(OdometryPortTest, OfAnotherFrameOfTheRobot) {
  // The odometry's frame is 0.2 m behind the base, and turns about that.
  const geometry::Rigid3 child_from_base = {.rotation = {},
                                            .translation = {0.2, 0, 0}};
  ASSERT_TRUE(port_.Add(At({}), child_from_base).ok());
  messages::Odometry message = At({{0, 0}, 0.1});
  message.twist.twist.linear.x = 0.3;
  message.twist.twist.angular.z = 1;
  ASSERT_TRUE(port_.Add(message, child_from_base).ok());
  const auto odom_from_base = port_.OdomFromBaseAt(testing_.real.Now());
  ASSERT_TRUE(odom_from_base.has_value());
  EXPECT_NEAR(odom_from_base->translation.x, 0.2 * std::cos(0.1), 1e-9);
  EXPECT_NEAR(odom_from_base->translation.y, 0.2 * std::sin(0.1), 1e-9);
  EXPECT_NEAR(Last().forward_mps, 0.3, 1e-9);
}

TEST_F(OdometryPortTest, PosesThatLeapDoNotTurnWheels) {
  ASSERT_TRUE(port_.Add(At({}), {}).ok());
  ASSERT_TRUE(port_.Add(At({{0.01, 0}, 0}), {}).ok());
  // Somebody has reset it, or corrects it.
  ASSERT_TRUE(port_.Add(At({{40, 3}, 3}), {}).ok());
  ASSERT_TRUE(port_.Add(At({{40, 3}, 3}), {}).ok());
  EXPECT_EQ(port_.leaps(), 1);
  EXPECT_NEAR(Last().left_wheel_m, 0.01, 1e-9);
}

TEST_F(OdometryPortTest, BetweenTwoMessages) {
  ASSERT_TRUE(port_.Add(At({}), {}).ok());
  const base::MonotonicTime first = testing_.real.Now();
  ASSERT_TRUE(port_.Add(At({{0.02, 0}, 0.04}), {}).ok());
  const auto middle =
      port_.OdomFromBaseAt(first + std::chrono::milliseconds(5));
  ASSERT_TRUE(middle.has_value());
  EXPECT_NEAR(middle->translation.x, 0.005, 1e-6);
  EXPECT_NEAR((middle->rotation * geometry::Vec3{1, 0, 0}).y, 0.01, 1e-5);
  EXPECT_FALSE(
      port_.OdomFromBaseAt(first - std::chrono::milliseconds(1)).has_value());
  EXPECT_NEAR(
      port_.OdomFromBaseAt(first + std::chrono::seconds(1))->translation.x,
      0.02, 1e-9);
}

TEST_F(OdometryPortTest, WhatIsNoOdometryIsCountedAndDropped) {
  ASSERT_TRUE(port_.Add(At({}), {}).ok());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  messages::Odometry nowhere = At({});
  nowhere.pose.pose.position.x = nan;
  messages::Odometry turned = At({});
  turned.pose.pose.orientation.w = 7;
  messages::Odometry fast = At({});
  fast.twist.twist.linear.x = 300;
  messages::Odometry spinning = At({});
  spinning.twist.twist.angular.z = nan;
  for (const auto& message : {nowhere, turned, fast, spinning}) {
    EXPECT_EQ(port_.Add(message, {}).code(),
              absl::StatusCode::kInvalidArgument);
  }
  messages::Odometry old = At({});
  old.header.stamp = messages::TimeOf(testing_.SystemNow() - 900'000'000);
  EXPECT_FALSE(port_.Add(old, {}).ok());
  EXPECT_EQ(port_.Health().corrupt, 5);
  EXPECT_EQ(port_.TakeReadings().size(), 1U);
}

}  // namespace
}  // namespace treeline::robot_ports
