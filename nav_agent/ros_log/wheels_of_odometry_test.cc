#include "nav_agent/ros_log/wheels_of_odometry.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "nav_agent/core/slope_odometry.h"

namespace treeline::ros_log {
namespace {

constexpr double kTrack_m = 0.54;

base::MonotonicTime At(double seconds) {
  return base::MonotonicTime(std::chrono::nanoseconds(
      static_cast<int64_t>(std::llround(seconds * 1e9))));
}

// The agent's own odometry, fed with these wheels, comes to the same poses:
// curves to both sides, backward, on the spot, and across the turn from pi to
// -pi.
TEST(WheelsOfOdometryTest, IntegratedAgainTheyGiveThePoses) {
  WheelsOfOdometry wheels(kTrack_m);
  auto odometry = core::SlopeOdometry::Create(
      {.wheel_track_m = kTrack_m, .uses_yaw_rate = false});
  ASSERT_TRUE(odometry.ok());
  geometry::Rigid2 pose = {{3, -2}, 2.5};
  const geometry::Rigid2 start = pose;
  for (int i = 0; i < 400; ++i) {
    ASSERT_TRUE(odometry->Add(wheels.Add(At(0.05 * i), pose)).ok());
    const geometry::Rigid2 from_start = start.Inverse() * pose;
    EXPECT_NEAR(odometry->PlanarOdomFromBase().translation.x,
                from_start.translation.x, 1e-9);
    EXPECT_NEAR(odometry->PlanarOdomFromBase().translation.y,
                from_start.translation.y, 1e-9);
    EXPECT_NEAR(
        geometry::NormalizedAngle_rad(odometry->PlanarOdomFromBase().yaw_rad -
                                      from_start.yaw_rad),
        0, 1e-9);
    // An arc: way and turn.
    const double way_m = i % 100 < 20 ? 0 : (i % 70 < 20 ? -0.02 : 0.03);
    const double turn_rad = 0.08 * std::sin(0.05 * i);
    const double half_rad = turn_rad / 2;
    const double chord_m = std::abs(half_rad) < 1e-12
                               ? way_m
                               : way_m * std::sin(half_rad) / half_rad;
    pose = pose * geometry::Rigid2{{chord_m * std::cos(half_rad),
                                    chord_m * std::sin(half_rad)},
                                   turn_rad};
  }
}

TEST(WheelsOfOdometryTest, SpeedsAreThoseSinceThePoseBefore) {
  WheelsOfOdometry wheels(kTrack_m);
  EXPECT_EQ(wheels.Add(At(1), {}).forward_mps, 0);
  const core::BaseReading ahead = wheels.Add(At(1.5), {{0.25, 0}, 0});
  EXPECT_DOUBLE_EQ(ahead.forward_mps, 0.5);
  EXPECT_DOUBLE_EQ(ahead.left_wheel_m, 0.25);
  EXPECT_DOUBLE_EQ(ahead.right_wheel_m, 0.25);
  const core::BaseReading turned = wheels.Add(At(2), {{0.25, 0}, 1});
  EXPECT_DOUBLE_EQ(turned.yaw_rate_radps, 2);
  EXPECT_NEAR(turned.right_wheel_m - turned.left_wheel_m, kTrack_m, 1e-12);
  // The same time again: no speed.
  EXPECT_EQ(wheels.Add(At(2), {{0.5, 0}, 1}).forward_mps, 0);
}

}  // namespace
}  // namespace treeline::ros_log
