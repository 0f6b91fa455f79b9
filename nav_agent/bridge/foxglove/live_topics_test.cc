#include "nav_agent/bridge/foxglove/live_topics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <set>

#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::foxglove {
namespace {

using agent_service::AgentState;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr int64_t kNow_ns = 1'700'000'000'250'000'000;

class LiveTopicsTest : public ::testing::Test {
 protected:
  LiveTopicsTest() {
    auto map = std::make_shared<behavior::NavigatorMap>();
    for (int i = 0; i < 2; ++i) {
      map->levels.levels.emplace_back().grid =
          core::OccupancyGrid::Filled(4, 3, 0.05, {}, core::Occupancy::kFree);
    }
    info_.map = map;
    state_.number = 1;
    state_.snapshot.pose.emplace();
    state_.snapshot.pose->pose = {.map_from_base = {{1, 2}, 0},
                                  .place = {.level = 1, .height_m = 3}};
  }

  template <messages::Message M>
  M Only(LiveTopic topic) {
    const auto said = topics_.Next(topic, state_, kNow_ns);
    EXPECT_THAT(said, SizeIs(1));
    if (said.empty()) return {};
    const absl::StatusOr<M> message = messages::Decode<M>(said[0]);
    EXPECT_TRUE(message.ok()) << message.status();
    return message.value_or(M());
  }

  agent_service::AgentInfo info_;
  agent_service::AgentHub hub_{agent_service::AgentHubOptions()};
  agent_service::PictureKeeper camera_{std::chrono::milliseconds(0)};
  LiveTopics topics_{info_, hub_, &camera_};
  AgentState state_;
};

TEST_F(LiveTopicsTest, EveryTopicHasAChannelWithItsSchema) {
  const std::vector<Channel>& channels = LiveChannels();
  ASSERT_THAT(channels, SizeIs(kLiveTopics));
  std::set<std::string> names;
  for (size_t i = 0; i < channels.size(); ++i) {
    EXPECT_EQ(channels[i].id, i);
    EXPECT_FALSE(channels[i].schema.empty()) << channels[i].topic;
    EXPECT_THAT(channels[i].schema_name, HasSubstr("/msg/"));
    names.insert(channels[i].topic);
  }
  EXPECT_THAT(names, SizeIs(kLiveTopics));
}

TEST_F(LiveTopicsTest, TheRobotStandsOnItsLevel) {
  const auto frames = Only<messages::TFMessage>(LiveTopic::kFrames);
  ASSERT_THAT(frames.transforms, SizeIs(3));
  EXPECT_EQ(frames.transforms[0].header.frame_id, "map");
  EXPECT_EQ(frames.transforms[0].child_frame_id, "base_link");
  EXPECT_EQ(frames.transforms[0].transform.translation,
            (messages::Vector3{1, 2, 3}));
  EXPECT_EQ(messages::Nanoseconds(frames.transforms[0].header.stamp), kNow_ns);
  const auto pose = Only<messages::PoseWithCovarianceStamped>(LiveTopic::kPose);
  EXPECT_EQ(pose.pose.pose.position, (messages::Point{1, 2, 3}));
}

TEST_F(LiveTopicsTest, ARobotThatNobodyPlacedHasNoFrame) {
  state_.snapshot.pose.reset();
  EXPECT_THAT(topics_.Next(LiveTopic::kFrames, state_, kNow_ns), SizeIs(0));
  EXPECT_THAT(topics_.Next(LiveTopic::kPose, state_, kNow_ns), SizeIs(0));
  EXPECT_EQ(Only<messages::OccupancyGrid>(LiveTopic::kMap).info.width, 4U);
}

TEST_F(LiveTopicsTest, AStateIsToldOnce) {
  Only<messages::TwistStamped>(LiveTopic::kCommand);
  EXPECT_THAT(topics_.Next(LiveTopic::kCommand, state_, kNow_ns), SizeIs(0));
  ++state_.number;
  state_.snapshot.command.forward_mps = 0.5;
  EXPECT_EQ(Only<messages::TwistStamped>(LiveTopic::kCommand).twist.linear.x,
            0.5);
}

TEST_F(LiveTopicsTest, WhatStaysTheSameIsToldAgainToWhoBegins) {
  EXPECT_EQ(Only<messages::OccupancyGrid>(LiveTopic::kMap).info.height, 3U);
  Only<messages::Path>(LiveTopic::kPlan);
  ++state_.number;
  EXPECT_THAT(topics_.Next(LiveTopic::kMap, state_, kNow_ns), SizeIs(0));
  EXPECT_THAT(topics_.Next(LiveTopic::kPlan, state_, kNow_ns), SizeIs(0));
  topics_.Begin(LiveTopic::kMap);
  topics_.Begin(LiveTopic::kPlan);
  EXPECT_THAT(topics_.Next(LiveTopic::kMap, state_, kNow_ns), SizeIs(1));
  EXPECT_THAT(topics_.Next(LiveTopic::kPlan, state_, kNow_ns), SizeIs(1));
  // Another level, and another path.
  state_.snapshot.pose->pose.place.level = 0;
  state_.snapshot.path.emplace_back();
  EXPECT_THAT(topics_.Next(LiveTopic::kMap, state_, kNow_ns), SizeIs(1));
  EXPECT_THAT(Only<messages::Path>(LiveTopic::kPlan).poses, SizeIs(1));
}

TEST_F(LiveTopicsTest, ALevelThatTheMapLacksIsNotDrawn) {
  state_.snapshot.pose->pose.place.level = 7;
  EXPECT_THAT(topics_.Next(LiveTopic::kMap, state_, kNow_ns), SizeIs(0));
}

TEST_F(LiveTopicsTest, AScanIsPointsAboveTheGround) {
  state_.snapshot.scan_in_map = {{5, 6}, {7, 8}};
  const auto cloud = Only<messages::PointCloud2>(LiveTopic::kScan);
  ASSERT_THAT(cloud.fields, SizeIs(3));
  EXPECT_EQ(cloud.width, 2U);
  EXPECT_EQ(cloud.point_step, 12U);
  ASSERT_THAT(cloud.data, SizeIs(24));
  std::array<float, 6> values;
  std::memcpy(values.data(), cloud.data.data(), cloud.data.size());
  EXPECT_EQ(values[3], 7);
  EXPECT_EQ(values[4], 8);
  EXPECT_NEAR(values[5], 3, 0.1);
  // None at all is a cloud, too: what was drawn goes.
  ++state_.number;
  state_.snapshot.scan_in_map.clear();
  EXPECT_EQ(Only<messages::PointCloud2>(LiveTopic::kScan).width, 0U);
}

TEST_F(LiveTopicsTest, TheCostmapTellsSeenFromMapped) {
  control::CostmapView& view = state_.snapshot.costmap;
  view.origin_in_map = {1, 2};
  view.width = 3;
  view.height = 1;
  view.cells = {0, 1, 2};
  const auto grid = Only<messages::OccupancyGrid>(LiveTopic::kCostmap);
  EXPECT_EQ(grid.data, (std::vector<int8_t>{0, 80, 100}));
  EXPECT_EQ(grid.info.origin.position, (messages::Point{1, 2, 3}));
}

TEST_F(LiveTopicsTest, TheReportComesEachSecondAndWithEachMode) {
  Only<messages::DiagnosticArray>(LiveTopic::kDiagnostics);
  ++state_.number;
  EXPECT_THAT(
      topics_.Next(LiveTopic::kDiagnostics, state_, kNow_ns + 100'000'000),
      SizeIs(0));
  state_.snapshot.mode = behavior::NavigatorMode::kDriving;
  const auto report = Only<messages::DiagnosticArray>(LiveTopic::kDiagnostics);
  for (const messages::DiagnosticStatus& status : report.status) {
    EXPECT_NE(status.name, "treeline: topics");
  }
  EXPECT_THAT(
      topics_.Next(LiveTopic::kDiagnostics, state_, kNow_ns + 1'000'000'000),
      SizeIs(1));
}

TEST_F(LiveTopicsTest, WhoComesLateIsToldTheLastEvents) {
  for (int i = 0; i < 60; ++i) hub_.AddEvent(i, "goal", absl::StrCat(i));
  auto said = topics_.Next(LiveTopic::kEvents, state_, kNow_ns);
  ASSERT_THAT(said, SizeIs(50));
  const auto line = messages::Decode<messages::Log>(said.back());
  ASSERT_TRUE(line.ok());
  EXPECT_EQ(line->name, "treeline.goal");
  EXPECT_EQ(line->msg, "59");
  EXPECT_THAT(topics_.Next(LiveTopic::kEvents, state_, kNow_ns), SizeIs(0));
  hub_.AddEvent(60, "lost", "where");
  EXPECT_THAT(topics_.Next(LiveTopic::kEvents, state_, kNow_ns), SizeIs(1));
}

TEST_F(LiveTopicsTest, APictureIsToldOnce) {
  EXPECT_THAT(topics_.Next(LiveTopic::kCamera, state_, kNow_ns), SizeIs(0));
  core::RgbdFrame frame;
  frame.stamp = base::MonotonicTime(std::chrono::seconds(1));
  frame.frame.color = {
      .width = 4, .height = 2, .rgb = std::vector<uint8_t>(4 * 2 * 3, 90)};
  camera_.Keep(frame);
  const auto picture = Only<messages::CompressedImage>(LiveTopic::kCamera);
  EXPECT_EQ(picture.format, "jpeg");
  EXPECT_FALSE(picture.data.empty());
  EXPECT_THAT(topics_.Next(LiveTopic::kCamera, state_, kNow_ns), SizeIs(0));
  LiveTopics without(info_, hub_, nullptr);
  EXPECT_THAT(without.Next(LiveTopic::kCamera, state_, kNow_ns), SizeIs(0));
}

}  // namespace
}  // namespace treeline::foxglove
