#include "common/ros2/conversions/transform_history.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "common/ros2/conversions/geometry_values.h"

namespace treeline::conversions {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr int64_t kSecond_ns = 1'000'000'000;

messages::TFMessage Message(const std::string& parent, const std::string& child,
                            double time_s, const geometry::Rigid3& value) {
  messages::TransformStamped transform;
  transform.header.stamp = messages::TimeOf(static_cast<int64_t>(time_s * 1e9));
  transform.header.frame_id = parent;
  transform.child_frame_id = child;
  transform.transform = TransformOf(value);
  return {.transforms = {transform}};
}

geometry::Rigid3 At(double x, double yaw_rad) {
  return {geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad}), {x, 0, 0}};
}

// odom -> base moves, turning left by a right angle a second; base -> camera
// stands 0.5 m ahead.
TransformHistory History() {
  TransformHistory history;
  for (int i = 0; i <= 2; ++i) {
    history.Add(
        Message("/odom", "base", 10 + i, At(i, i * std::numbers::pi / 2)));
  }
  history.AddStatic(Message("base", "/camera", 0, At(0.5, 0)));
  return history;
}

TEST(TransformHistoryTest, BetweenTwoMessagesIsBetweenTwoPoses) {
  const auto pose = History().Find("odom", "camera", 21 * kSecond_ns / 2);
  ASSERT_TRUE(pose.ok()) << pose.status();
  const double half = 0.5 * std::sqrt(0.5);
  EXPECT_NEAR(pose->translation.x, 0.5 + half, 1e-12);
  EXPECT_NEAR(pose->translation.y, half, 1e-12);
  const auto back = History().Find("camera", "odom", 21 * kSecond_ns / 2);
  ASSERT_TRUE(back.ok());
  const geometry::PoseError error =
      geometry::ErrorBetween(back->Inverse(), *pose);
  EXPECT_LT(error.translation_m, 1e-12);
}

TEST(TransformHistoryTest, BeyondTheEndsAndInGapsNothingIsKnown) {
  TransformHistory history = History();
  for (const double time_s : {9.9, 12.1}) {
    EXPECT_THAT(
        std::string(
            history.Find("odom", "camera", static_cast<int64_t>(time_s * 1e9))
                .status()
                .message()),
        HasSubstr("where base was before the first or after the last"));
  }
  history.Add(Message("odom", "base", 20, At(5, 0)));
  EXPECT_THAT(
      std::string(
          history.Find("odom", "base", 15 * kSecond_ns).status().message()),
      HasSubstr("a gap of 8 s"));
  EXPECT_TRUE(history.Find("odom", "base", 20 * kSecond_ns).ok());
}

TEST(TransformHistoryTest, WhatNeverMovesHoldsAlways) {
  TransformHistory history;
  history.Add(Message("base", "camera", 10, At(1, 0)));
  history.Add(Message("base", "camera", 11, At(1, 0)));
  EXPECT_FALSE(history.Moves("camera"));
  EXPECT_TRUE(history.Find("base", "camera", 500 * kSecond_ns).ok());
  history.Add(Message("base", "camera", 12, At(2, 0)));
  EXPECT_TRUE(history.Moves("camera"));
  EXPECT_FALSE(history.Find("base", "camera", 500 * kSecond_ns).ok());
}

TEST(TransformHistoryTest, APoseTakesTheChildOver) {
  TransformHistory history = History();
  history.AddPose("world", "base", 10 * kSecond_ns, At(7, 0));
  history.AddPose("world", "base", 11 * kSecond_ns, At(8, 0));
  history.Add(Message("odom", "base", 10, At(0, 0)));
  EXPECT_THAT(history.ChainFrom("camera"),
              ElementsAre("camera", "base", "world"));
  EXPECT_NEAR(history.Find("world", "camera", 10 * kSecond_ns)->translation.x,
              7.5, 1e-12);
  EXPECT_THAT(
      std::string(
          history.Find("odom", "camera", 10 * kSecond_ns).status().message()),
      HasSubstr("do not tell where camera is in odom"));
}

TEST(TransformHistoryTest, LoopsEnd) {
  TransformHistory history;
  history.AddStatic(Message("a", "b", 0, At(1, 0)));
  history.AddStatic(Message("b", "a", 0, At(1, 0)));
  EXPECT_FALSE(history.Find("c", "a", 0).ok());
  EXPECT_FALSE(history.Find("a", "c", 0).ok());
  EXPECT_LE(history.ChainFrom("a").size(), 3U);
}

}  // namespace
}  // namespace treeline::conversions
