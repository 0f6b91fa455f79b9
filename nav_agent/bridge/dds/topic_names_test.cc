#include "nav_agent/bridge/dds/topic_names.h"

#include <gtest/gtest.h>

namespace treeline::dds {
namespace {

TEST(TopicNamesTest, RelativeNamesAreOfTheNamespace) {
  const NodeName node = {.name_space = "/robot1", .remappings = {}};
  EXPECT_EQ(*FullTopicName("scan", node), "/robot1/scan");
  EXPECT_EQ(*FullTopicName("/scan", node), "/scan");
  EXPECT_EQ(*FullTopicName("camera/image", node), "/robot1/camera/image");
  EXPECT_EQ(*FullTopicName("~/lost", node), "/robot1/treeline/lost");
  EXPECT_EQ(*FullTopicName("scan", NodeName{}), "/scan");
  EXPECT_EQ(*FullTopicName("scan", {.name_space = "/", .remappings = {}}),
            "/scan");
  EXPECT_EQ(*FullTopicName("scan", {.name_space = "a/b/", .remappings = {}}),
            "/a/b/scan");
}

TEST(TopicNamesTest, RemappingComparesWhatNamesMean) {
  const NodeName node = {.name_space = "robot1",
                         .remappings = {{.from = "scan", .to = "front/scan"},
                                        {.from = "/robot1/odom", .to = "/o"},
                                        {.from = "scan", .to = "never"}}};
  EXPECT_EQ(*FullTopicName("scan", node), "/robot1/front/scan");
  EXPECT_EQ(*FullTopicName("/robot1/scan", node), "/robot1/front/scan");
  EXPECT_EQ(*FullTopicName("/scan", node), "/scan");
  EXPECT_EQ(*FullTopicName("odom", node), "/o");
}

TEST(TopicNamesTest, BadNamesAreErrors) {
  for (const char* name : {"", "/", "a//b", "a/", "2d", "a-b", "a b", "~x"}) {
    EXPECT_FALSE(FullTopicName(name, NodeName{}).ok()) << name;
  }
}

TEST(TopicNamesTest, DdsSeesAPrefix) {
  EXPECT_EQ(DdsTopicName("/robot1/scan"), "rt/robot1/scan");
  EXPECT_EQ(DdsRequestTopicName("/a/_action/send_goal"),
            "rq/a/_action/send_goalRequest");
  EXPECT_EQ(DdsReplyTopicName("/a/_action/send_goal"),
            "rr/a/_action/send_goalReply");
}

TEST(TopicNamesTest, DdsTypeNames) {
  EXPECT_EQ(DdsTypeName("sensor_msgs/msg/LaserScan"),
            "sensor_msgs::msg::dds_::LaserScan_");
  EXPECT_EQ(DdsTypeName("nav2_msgs/action/NavigateToPose_Goal"),
            "nav2_msgs::action::dds_::NavigateToPose_Goal_");
}

TEST(TopicNamesTest, Remappings) {
  const auto rule = ParseRemapping("scan:=/front/scan");
  ASSERT_TRUE(rule.ok()) << rule.status();
  EXPECT_EQ(rule->from, "scan");
  EXPECT_EQ(rule->to, "/front/scan");
  EXPECT_FALSE(ParseRemapping("scan").ok());
  EXPECT_FALSE(ParseRemapping(":=b").ok());
  EXPECT_FALSE(ParseRemapping("a:=").ok());
  EXPECT_FALSE(ParseRemapping("a:=b:=c").ok());
}

}  // namespace
}  // namespace treeline::dds
