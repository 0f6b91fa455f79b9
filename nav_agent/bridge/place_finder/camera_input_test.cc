#include "nav_agent/bridge/place_finder/camera_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/ros2/conversions/geometry_values.h"

namespace treeline::place_finder {
namespace {

using ::testing::HasSubstr;

messages::CameraInfo Info(uint32_t width) {
  messages::CameraInfo info;
  info.width = width;
  info.height = 1;
  info.k = {2, 0, 0.5, 0, 2, 0, 0, 0, 1};
  return info;
}

messages::Image Color(int32_t second, uint8_t value) {
  return {.header = {.stamp = {second, 0}, .frame_id = "optical"},
          .height = 1,
          .width = 2,
          .encoding = "mono8",
          .step = 2,
          .data = {value, value}};
}

messages::Image Depth(int32_t second, uint32_t nanosec) {
  return {.header = {.stamp = {second, nanosec}, .frame_id = "optical"},
          .height = 1,
          .width = 2,
          .encoding = "16UC1",
          .step = 4,
          .data = {1, 0, 2, 0}};
}

TEST(CameraInputTest, GivesTheNewestPicture) {
  CameraInput camera({});
  camera.AddColor(Color(1, 10));
  EXPECT_THAT(std::string(camera.Newest().status().message()),
              HasSubstr("camera_info"));
  ASSERT_TRUE(camera.AddInfo(Info(2)).ok());
  camera.AddColor(Color(2, 20));
  const auto frame = camera.Newest();
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->frame.color.rgb[0], 20);
  EXPECT_EQ(frame->sequence, 1);
  EXPECT_EQ(frame->stamp, conversions::TimeOf({2, 0}));
  EXPECT_EQ(camera.NewestStamp(), frame->stamp);
  EXPECT_FALSE(frame->frame.depth.has_value());
  EXPECT_EQ(camera.frame_id(), "optical");
}

TEST(CameraInputTest, ColourWaitsForTheDepthOfItsMoment) {
  CameraInput camera({.has_depth = true});
  ASSERT_TRUE(camera.AddInfo(Info(2)).ok());
  camera.AddColor(Color(1, 10));
  camera.AddColor(Color(2, 20));
  EXPECT_FALSE(camera.NewestStamp().has_value());
  EXPECT_THAT(std::string(camera.Newest().status().message()),
              HasSubstr("same stamps"));
  camera.AddDepth(Depth(1, 10'000'000));
  auto frame = camera.Newest();
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->frame.color.rgb[0], 10);
  EXPECT_EQ(frame->sequence, 0);
  ASSERT_TRUE(frame->frame.depth.has_value());
  EXPECT_EQ(frame->frame.depth->values[1], 2);
  camera.AddDepth(Depth(2, 0));
  EXPECT_EQ(camera.Newest()->frame.color.rgb[0], 20);
}

TEST(CameraInputTest, AClockThatBeginsAnewIsFollowed) {
  CameraInput camera({});
  ASSERT_TRUE(camera.AddInfo(Info(2)).ok());
  camera.AddColor(Color(100, 1));
  camera.AddColor(Color(3, 2));
  EXPECT_EQ(camera.NewestStamp(), conversions::TimeOf({3, 0}));
}

TEST(CameraInputTest, TheCalibrationOfAnotherSizeIsAnError) {
  CameraInput camera({});
  ASSERT_TRUE(camera.AddInfo(Info(3)).ok());
  camera.AddColor(Color(1, 10));
  EXPECT_THAT(std::string(camera.Newest().status().message()),
              HasSubstr("camera_info of 3 x 1"));
}

}  // namespace
}  // namespace treeline::place_finder
