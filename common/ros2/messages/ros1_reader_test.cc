#include "common/ros2/messages/ros1_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/message_codec.h"

namespace treeline::messages {
namespace {

using ::testing::HasSubstr;

template <typename T>
void Put(std::vector<uint8_t>& to, T value) {
  const auto* raw = reinterpret_cast<const uint8_t*>(&value);
  to.insert(to.end(), raw, raw + sizeof(T));
}
void PutText(std::vector<uint8_t>& to, const std::string& text) {
  Put(to, static_cast<uint32_t>(text.size()));
  to.insert(to.end(), text.begin(), text.end());
}

// A geometry_msgs/PoseStamped, byte by byte as ROS 1 writes it.
std::vector<uint8_t> PoseBytes() {
  std::vector<uint8_t> bytes;
  Put(bytes, uint32_t{77});  // header.seq
  Put(bytes, uint32_t{12});
  Put(bytes, uint32_t{345});
  PutText(bytes, "odom");
  for (const double value : {1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8}) {
    Put(bytes, value);
  }
  return bytes;
}

TEST(Ros1ReaderTest, APoseAsRos1WritesIt) {
  const auto pose = DecodeRos1<PoseStamped>(PoseBytes());
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_EQ(pose->header.stamp, (Time{12, 345}));
  EXPECT_EQ(pose->header.frame_id, "odom");
  EXPECT_EQ(pose->pose.position, (Point{1, 2, 3}));
  EXPECT_EQ(pose->pose.orientation, (Quaternion{0, 0, 0.6, 0.8}));
  const auto header = DecodeHeaderRos1(PoseBytes());
  ASSERT_TRUE(header.ok());
  EXPECT_EQ(*header, pose->header);
}

TEST(Ros1ReaderTest, WhatIsCutOffIsNamed) {
  const std::vector<uint8_t> bytes = PoseBytes();
  for (size_t size = 0; size < bytes.size(); ++size) {
    const auto pose =
        DecodeRos1<PoseStamped>(std::span(bytes).subspan(0, size));
    EXPECT_THAT(std::string(pose.status().message()),
                HasSubstr("geometry_msgs/msg/PoseStamped: ROS 1: at byte "))
        << size;
  }
  std::vector<uint8_t> longer = bytes;
  longer.push_back(0);
  EXPECT_THAT(std::string(DecodeRos1<PoseStamped>(longer).status().message()),
              HasSubstr("1 bytes are left"));
}

TEST(Ros1ReaderTest, MoreElementsThanBytesAreNotAllocated) {
  std::vector<uint8_t> bytes;
  Put(bytes, uint32_t{0xffffffff});
  EXPECT_FALSE(DecodeRos1<TFMessage>(bytes).ok());
}

}  // namespace
}  // namespace treeline::messages
