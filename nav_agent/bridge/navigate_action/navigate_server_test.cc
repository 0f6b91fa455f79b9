// Over DDS, with clients that this test plays.
#include "nav_agent/bridge/navigate_action/navigate_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/ros2/messages/message_codec.h"
#include "nav_agent/bridge/dds/testing_client.h"
#include "nav_agent/bridge/dds/testing_domain.h"

namespace treeline::navigate_action {
namespace {

using messages::GoalStatus;
using ::testing::HasSubstr;
using Bytes = std::vector<uint8_t>;

constexpr char kInside[] = "/robot1/navigate_to_pose/_action/";

// The three clients that an action client is.
struct ActionClient {
  explicit ActionClient(const dds::Domain& domain)
      : send_goal(domain, std::string(kInside) + "send_goal",
                  "nav2_msgs/action/NavigateToPose_SendGoal"),
        cancel_goal(domain, std::string(kInside) + "cancel_goal",
                    "action_msgs/srv/CancelGoal"),
        get_result(domain, std::string(kInside) + "get_result",
                   "nav2_msgs/action/NavigateToPose_GetResult") {}
  bool IsMatched() const {
    return send_goal.IsMatched() && cancel_goal.IsMatched() &&
           get_result.IsMatched();
  }

  dds::TestingClient send_goal;
  dds::TestingClient cancel_goal;
  dds::TestingClient get_result;
};

class NavigateServerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto domain =
        dds::Domain::Join({.id = dds::TestingDomain(), .interface = "lo"});
    ASSERT_TRUE(domain.ok()) << domain.status();
    domain_ = *std::move(domain);
    auto node = dds::Node::Create(
        *domain_, {.name_space = "robot1", .node = "a", .remappings = {}});
    ASSERT_TRUE(node.ok()) << node.status();
    node_ = *std::move(node);
    auto server = NavigateServer::Open(
        *node_,
        [this](const std::string& service, const std::string& type) {
          return node_->Serve(service, type);
        },
        "navigate_to_pose",
        {.set_goal = [this](const messages::PoseStamped&)
             -> absl::StatusOr<uint64_t> { return ++goals_; },
         .cancel = [](uint64_t) { return absl::OkStatus(); }},
        [this](const std::string& line) { warnings_ += line + "\n"; });
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  template <typename Holds>
  bool Until(Holds holds) {
    for (int i = 0; i < 3000; ++i) {
      server_->Answer(kMoment);
      if (holds()) return true;
      node_->Wait(std::chrono::milliseconds(10));
    }
    return false;
  }
  template <typename M>
  absl::StatusOr<M> Reply(dds::TestingClient& client, int64_t asked) {
    std::optional<Bytes> bytes;
    if (!Until([&] { return (bytes = client.ReplyTo(asked)).has_value(); })) {
      return absl::DeadlineExceededError("no reply");
    }
    return messages::Decode<M>(*bytes);
  }
  absl::Status Tell(uint64_t goal, behavior::GoalState goal_state) {
    agent_service::AgentState state;
    state.snapshot.goal.emplace();
    state.snapshot.goal->id = goal;
    state.snapshot.goal->state = goal_state;
    return server_->Tell(state, kMoment, "map");
  }
  static messages::NavigateToPoseSendGoalRequest Goal(uint8_t id) {
    messages::NavigateToPoseSendGoalRequest request;
    request.goal_id.uuid[0] = id;
    request.goal.pose.header.frame_id = "map";
    return request;
  }

  static constexpr Moment kMoment = {.now = {},
                                     .stamp = {.sec = 7, .nanosec = 8}};
  std::unique_ptr<dds::Domain> domain_;
  std::unique_ptr<dds::Node> node_;
  std::unique_ptr<NavigateServer> server_;
  uint64_t goals_ = 0;
  std::string warnings_;
};

TEST_F(NavigateServerTest, AGoalFromItsRequestToItsResult) {
  ActionClient client(*domain_);
  auto feedback = node_->Subscribe(
      std::string(kInside) + "feedback",
      messages::NavigateToPoseFeedbackMessage::kName, {.depth = 10});
  ASSERT_TRUE(feedback.ok());
  ASSERT_TRUE(Until([&] { return client.IsMatched(); }));
  const int64_t sent = client.send_goal.Ask(messages::Encode(Goal(1)));
  const auto accepted =
      Reply<messages::NavigateToPoseSendGoalResponse>(client.send_goal, sent);
  ASSERT_TRUE(accepted.ok()) << accepted.status();
  EXPECT_TRUE(accepted->accepted);
  EXPECT_EQ(accepted->stamp, kMoment.stamp);

  // Whoever comes late is told what there is.
  auto status =
      node_->Subscribe(std::string(kInside) + "status",
                       messages::GoalStatusArray::kName, dds::kLatched);
  ASSERT_TRUE(status.ok());
  std::vector<dds::Sample> statuses;
  ASSERT_TRUE(Until([&] { return !(statuses = (*status)->Take()).empty(); }));
  const auto array =
      messages::Decode<messages::GoalStatusArray>(statuses.back().bytes);
  ASSERT_TRUE(array.ok() && array->status_list.size() == 1);
  EXPECT_EQ(array->status_list[0].status, GoalStatus::kExecuting);

  const int64_t asked = client.get_result.Ask(messages::Encode(
      messages::NavigateToPoseGetResultRequest{.goal_id = Goal(1).goal_id}));
  std::vector<dds::Sample> told;
  ASSERT_TRUE(Until([&] {
    EXPECT_TRUE(Tell(1, behavior::GoalState::kActive).ok());
    return !(told = (*feedback)->Take()).empty();
  }));
  const auto on_the_way =
      messages::Decode<messages::NavigateToPoseFeedbackMessage>(told[0].bytes);
  ASSERT_TRUE(on_the_way.ok());
  EXPECT_EQ(on_the_way->goal_id, Goal(1).goal_id);
  EXPECT_FALSE(client.get_result.ReplyTo(asked).has_value());

  ASSERT_TRUE(Tell(1, behavior::GoalState::kSucceeded).ok());
  const auto result = Reply<messages::NavigateToPoseGetResultResponse>(
      client.get_result, asked);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->status, GoalStatus::kSucceeded);
  EXPECT_EQ(warnings_, "");
}

TEST_F(NavigateServerTest, WhatIsBrokenIsRefusedAndNamed) {
  ActionClient client(*domain_);
  ASSERT_TRUE(Until([&] { return client.IsMatched(); }));
  Bytes half = messages::Encode(Goal(1));
  half.resize(half.size() / 2);
  const int64_t broken = client.send_goal.Ask(half);
  const auto refused =
      Reply<messages::NavigateToPoseSendGoalResponse>(client.send_goal, broken);
  ASSERT_TRUE(refused.ok()) << refused.status();
  EXPECT_FALSE(refused->accepted);
  EXPECT_THAT(warnings_, HasSubstr("SendGoal_Request"));
  const auto cancel = Reply<messages::CancelGoalResponse>(
      client.cancel_goal, client.cancel_goal.Ask(Bytes{0, 1, 0, 0, 9}));
  ASSERT_TRUE(cancel.ok()) << cancel.status();
  EXPECT_EQ(cancel->return_code, messages::CancelGoalResponse::kRejected);
  const auto unknown = Reply<messages::NavigateToPoseGetResultResponse>(
      client.get_result, client.get_result.Ask(messages::Encode(
                             messages::NavigateToPoseGetResultRequest{})));
  ASSERT_TRUE(unknown.ok()) << unknown.status();
  EXPECT_EQ(unknown->status, GoalStatus::kUnknown);
  EXPECT_EQ(goals_, 0U);
}

TEST_F(NavigateServerTest, WhoWaitsForAResultHearsThatTheAgentEnds) {
  ActionClient client(*domain_);
  ASSERT_TRUE(Until([&] { return client.IsMatched(); }));
  const auto accepted = Reply<messages::NavigateToPoseSendGoalResponse>(
      client.send_goal, client.send_goal.Ask(messages::Encode(Goal(1))));
  ASSERT_TRUE(accepted.ok() && accepted->accepted);
  const int64_t asked = client.get_result.Ask(messages::Encode(
      messages::NavigateToPoseGetResultRequest{.goal_id = Goal(1).goal_id}));
  server_->Close(kMoment);
  const auto result = Reply<messages::NavigateToPoseGetResultResponse>(
      client.get_result, asked);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->status, GoalStatus::kAborted);
  EXPECT_EQ(result->result.error_msg, "the agent ends");
}

// It goes on: another client may cancel it and ask for its result.
TEST_F(NavigateServerTest, AGoalOutlivesItsClient) {
  auto client = std::make_unique<ActionClient>(*domain_);
  ASSERT_TRUE(Until([&] { return client->IsMatched(); }));
  const auto accepted = Reply<messages::NavigateToPoseSendGoalResponse>(
      client->send_goal, client->send_goal.Ask(messages::Encode(Goal(1))));
  ASSERT_TRUE(accepted.ok() && accepted->accepted);
  client->get_result.Ask(messages::Encode(
      messages::NavigateToPoseGetResultRequest{.goal_id = Goal(1).goal_id}));
  client.reset();
  ActionClient other(*domain_);
  ASSERT_TRUE(Until([&] { return other.IsMatched(); }));
  const auto cancel = Reply<messages::CancelGoalResponse>(
      other.cancel_goal,
      other.cancel_goal.Ask(messages::Encode(messages::CancelGoalRequest{})));
  ASSERT_TRUE(cancel.ok());
  EXPECT_EQ(cancel->goals_canceling.size(), 1U);
  ASSERT_TRUE(Tell(1, behavior::GoalState::kCancelled).ok());
  const auto result = Reply<messages::NavigateToPoseGetResultResponse>(
      other.get_result, other.get_result.Ask(messages::Encode(
                            messages::NavigateToPoseGetResultRequest{
                                .goal_id = Goal(1).goal_id})));
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->status, GoalStatus::kCanceled);
}

TEST_F(NavigateServerTest, ClientsOfAnotherKindAreNamedOnce) {
  dds::TestingClient other(*domain_, std::string(kInside) + "send_goal",
                           "nav2_msgs/action/NavigateToPose_SendGoal", "");
  ASSERT_TRUE(Until([&] { return other.IsMatched(); }));
  other.SendRaw(messages::Encode(Goal(1)));
  other.SendRaw(messages::Encode(Goal(2)));
  ASSERT_TRUE(Until([&] { return !warnings_.empty(); }));
  server_->Answer(kMoment);
  EXPECT_THAT(warnings_, HasSubstr("RMW_IMPLEMENTATION"));
  EXPECT_EQ(std::ranges::count(warnings_, '\n'), 1);
  EXPECT_EQ(goals_, 0U);
}

}  // namespace
}  // namespace treeline::navigate_action
