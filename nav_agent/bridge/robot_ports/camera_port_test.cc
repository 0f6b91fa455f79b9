#include "nav_agent/bridge/robot_ports/camera_port.h"

#include <gtest/gtest.h>

#include "nav_agent/bridge/robot_ports/testing_ports.h"

namespace treeline::robot_ports {
namespace {

class CameraPortTest : public ::testing::Test {
 protected:
  messages::Image Picture(uint8_t grey, double later_s = 0.05) {
    testing_.real.Pass(later_s);
    messages::Image image;
    image.header = {.stamp = testing_.Stamp(), .frame_id = "optical"};
    image.width = 4;
    image.height = 2;
    image.step = 4;
    image.encoding = "mono8";
    image.data.assign(8, grey);
    return image;
  }
  static messages::CameraInfo Info() {
    messages::CameraInfo info;
    info.width = 4;
    info.height = 2;
    info.k = {4, 0, 1.5, 0, 4, 0.5, 0, 0, 1};
    return info;
  }

  TestingTime testing_;
  CameraPort port_{"image", {}, 0.2, testing_.time, testing_.real};
};

TEST_F(CameraPortTest, TheNewestPictureIsDecodedSoOften) {
  port_.AddColor(Picture(10));
  EXPECT_TRUE(port_.TakeFrames().empty()) << "no camera_info has come";
  ASSERT_TRUE(port_.AddInfo(Info()).ok());
  EXPECT_TRUE(port_.has_info());
  EXPECT_EQ(port_.Calibration().color.fx(), 4);
  port_.AddColor(Picture(20));
  port_.AddColor(Picture(30));
  const std::vector<core::RgbdFrame> frames = port_.TakeFrames();
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].frame.color.rgb[0], 30);
  EXPECT_EQ(frames[0].stamp, testing_.real.Now());
  EXPECT_EQ(frames[0].sequence, 2);
  EXPECT_EQ(port_.frame_id(), "optical");
  port_.AddColor(Picture(40));
  EXPECT_TRUE(port_.TakeFrames().empty()) << "too soon";
  port_.AddColor(Picture(50, 0.2));
  EXPECT_EQ(port_.TakeFrames().size(), 1U);
  testing_.real.Pass(1);
  EXPECT_TRUE(port_.TakeFrames().empty()) << "the same picture";
}

TEST_F(CameraPortTest, WhatIsNoPictureIsCounted) {
  ASSERT_TRUE(port_.AddInfo(Info()).ok());
  messages::Image torn = Picture(1);
  torn.data.resize(5);
  port_.AddColor(torn);
  EXPECT_TRUE(port_.TakeFrames().empty());
  EXPECT_EQ(port_.Health().corrupt, 1);
  EXPECT_FALSE(port_.AddInfo(messages::CameraInfo()).ok());
  EXPECT_EQ(port_.Health().corrupt, 2);
}

}  // namespace
}  // namespace treeline::robot_ports
