#include "nav_agent/bridge/dds/endpoints.h"

#include <gtest/gtest.h>

#include "nav_agent/bridge/dds/topic_names.h"

namespace treeline::dds {
namespace {

constexpr char kScan[] = "sensor_msgs/msg/LaserScan";
constexpr char kCloud[] = "sensor_msgs/msg/PointCloud2";
constexpr int kDomain = 7;

Endpoint Writer(const std::string& topic, const std::string& type,
                const Quality& quality = {}) {
  return {.topic = topic,
          .message_name = type,
          .quality = quality,
          .is_writer = true};
}
Endpoint Reader(const std::string& topic, const std::string& type,
                const Quality& quality = kSensorData) {
  return {.topic = topic, .message_name = type, .quality = quality};
}

TEST(EndpointsTest, NamesAreThoseOfRos) {
  const auto endpoint =
      EndpointOf(DdsTopicName("/robot1/scan"), DdsTypeName(kScan));
  ASSERT_TRUE(endpoint.has_value());
  EXPECT_EQ(endpoint->topic, "/robot1/scan");
  EXPECT_EQ(endpoint->message_name, kScan);
  EXPECT_FALSE(EndpointOf("rq/askRequest", DdsTypeName(kScan)).has_value());
  EXPECT_FALSE(EndpointOf("ros_discovery_info",
                          "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_")
                   .has_value());
  EXPECT_FALSE(EndpointOf("rt/scan", "LaserScan").has_value());
}

TEST(EndpointsTest, WhoFitsIsNoReason) {
  EXPECT_EQ(WhyNobody(Reader("/scan", kScan), {Writer("/scan", kScan)}, 0), "");
  EXPECT_EQ(WhyNobody(Reader("/scan", kScan),
                      {Writer("/scan", kScan, kSensorData)}, 0),
            "");
  EXPECT_EQ(
      WhyNobody(Writer("/cmd_vel", kScan), {Reader("/cmd_vel", kScan)}, 0), "");
}

TEST(EndpointsTest, AnotherNameIsTold) {
  EXPECT_EQ(WhyNobody(Reader("/scan", kScan),
                      {Writer("/robot1/scan", kScan), Reader("/x", kScan),
                       Writer("/front/scan", kScan), Writer("/y", kCloud)},
                      kDomain),
            "nobody publishes /scan in domain 7; of type "
            "sensor_msgs/msg/LaserScan there is /front/scan, /robot1/scan");
  EXPECT_EQ(WhyNobody(Writer("/cmd_vel", kScan), {Reader("/base/cmd", kScan)},
                      kDomain),
            "nobody listens on /cmd_vel in domain 7; of type "
            "sensor_msgs/msg/LaserScan there is /base/cmd");
}

TEST(EndpointsTest, AnotherTypeIsTold) {
  EXPECT_EQ(
      WhyNobody(Reader("/scan", kScan), {Writer("/scan", kCloud)}, kDomain),
      "/scan is of type sensor_msgs/msg/PointCloud2 there, and not "
      "sensor_msgs/msg/LaserScan");
}

TEST(EndpointsTest, AnotherQualityIsTold) {
  EXPECT_EQ(WhyNobody(Reader("/image", kCloud, {.is_reliable = true}),
                      {Writer("/image", kCloud, kSensorData)}, kDomain),
            "/image: the quality of service does not fit: it is published as "
            "best effort, and reliable is asked for here");
  EXPECT_EQ(WhyNobody(Writer("/tf", kScan, {.is_latched = false}),
                      {Reader("/tf", kScan, kLatched)}, kDomain),
            "/tf: the quality of service does not fit: who listens asks for "
            "transient local, and it is published as volatile here");
}

TEST(EndpointsTest, WhoIsThereIsNamedUpToSix) {
  EXPECT_EQ(WhyNobody(Reader("/scan", kScan), {Reader("/scan", kScan)}, 0),
            "nobody publishes /scan in domain 0, nor anything else: is the "
            "robot on, in this domain (ROS_DOMAIN_ID) and network?");
  std::vector<Endpoint> many;
  for (const char* topic : {"/a", "/b", "/c", "/d", "/e", "/f", "/g", "/h"}) {
    many.push_back(Writer(topic, kCloud));
  }
  EXPECT_EQ(WhyNobody(Reader("/scan", kScan), many, 0),
            "nobody publishes /scan in domain 0, nor any "
            "sensor_msgs/msg/LaserScan; there is /a, /b, /c, /d, /e, /f and 2 "
            "more");
}

}  // namespace
}  // namespace treeline::dds
