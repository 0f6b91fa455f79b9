#include "nav_agent/bridge/navigate_action/navigate_action.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

namespace treeline::navigate_action {
namespace {

using behavior::GoalState;
using messages::CancelGoalResponse;
using messages::GoalStatus;
using ::testing::HasSubstr;

messages::Uuid Id(uint8_t number) {
  messages::Uuid id;
  id.uuid[15] = number;
  return id;
}

Moment At(int second) {
  return {.now = base::MonotonicTime() + std::chrono::seconds(second),
          .stamp = {.sec = 1000 + second, .nanosec = 5}};
}

class NavigateActionTest : public ::testing::Test {
 protected:
  NavigateActionTest()
      : action_({.set_goal = [this](const messages::PoseStamped& pose)
                     -> absl::StatusOr<uint64_t> {
                   if (!refusal_.ok()) return refusal_;
                   last_pose_ = pose;
                   return ++goals_;
                 },
                 .cancel =
                     [this](uint64_t goal) {
                       cancelled_.push_back(goal);
                       return cancel_answer_;
                     }}) {}

  NavigateAction::Answer Send(uint8_t id, int second = 0) {
    messages::NavigateToPoseSendGoalRequest request;
    request.goal_id = Id(id);
    request.goal.pose.pose.position.x = id;
    return action_.Take(request, At(second));
  }
  static agent_service::AgentState State(uint64_t goal, GoalState state) {
    agent_service::AgentState published;
    published.snapshot.goal.emplace();
    published.snapshot.goal->id = goal;
    published.snapshot.goal->state = state;
    return published;
  }
  std::optional<messages::NavigateToPoseFeedback> Follow(uint64_t goal,
                                                         GoalState state,
                                                         int second = 1) {
    return action_.Follow(State(goal, state), At(second), "map");
  }
  int8_t StatusOf(uint8_t id) {
    for (const GoalStatus& status : action_.Statuses().status_list) {
      if (status.goal_info.goal_id == Id(id)) return status.status;
    }
    return GoalStatus::kUnknown;
  }
  CancelGoalResponse Cancel(const messages::Uuid& id,
                            const messages::Time& stamp = {}) {
    return action_.Cancel({.goal_info = {.goal_id = id, .stamp = stamp}});
  }

  absl::Status refusal_;
  absl::Status cancel_answer_;
  uint64_t goals_ = 0;
  std::vector<uint64_t> cancelled_;
  messages::PoseStamped last_pose_;
  NavigateAction action_;
};

TEST_F(NavigateActionTest, AGoalIsAcceptedDrivenAndReached) {
  const NavigateAction::Answer answer = Send(1);
  EXPECT_TRUE(answer.response.accepted) << answer.why;
  EXPECT_EQ(answer.response.stamp, At(0).stamp);
  EXPECT_EQ(last_pose_.pose.position.x, 1);
  EXPECT_EQ(StatusOf(1), GoalStatus::kExecuting);
  EXPECT_FALSE(action_.ResultOf(Id(1)).has_value());

  agent_service::AgentState state = State(1, GoalState::kActive);
  state.snapshot.pose.emplace();
  state.snapshot.pose->pose = {.map_from_base = {{3, 4}, 0},
                               .place = {.level = 0, .height_m = 0.5}};
  state.snapshot.goal->to_go_m = 6;
  state.snapshot.goal->recoveries = 2;
  state.snapshot.command.forward_mps = 0.5;
  const auto feedback = action_.Follow(state, At(7), "map");
  ASSERT_TRUE(feedback.has_value());
  EXPECT_EQ(action_.current_id(), Id(1));
  EXPECT_EQ(feedback->current_pose.header.frame_id, "map");
  EXPECT_EQ(feedback->current_pose.pose.position, (messages::Point{3, 4, 0.5}));
  EXPECT_EQ(feedback->navigation_time, (messages::Duration{7, 0}));
  EXPECT_EQ(feedback->estimated_time_remaining, (messages::Duration{12, 0}));
  EXPECT_EQ(feedback->number_of_recoveries, 2);
  EXPECT_EQ(feedback->distance_remaining, 6);
  // Who stands gets nowhere in a time that can be told.
  state.snapshot.command.forward_mps = 0;
  EXPECT_EQ(action_.Follow(state, At(8), "map")->estimated_time_remaining,
            messages::Duration());

  EXPECT_FALSE(Follow(1, GoalState::kSucceeded).has_value());
  EXPECT_EQ(StatusOf(1), GoalStatus::kSucceeded);
  EXPECT_EQ(action_.ResultOf(Id(1))->status, GoalStatus::kSucceeded);
  EXPECT_EQ(action_.ResultOf(Id(1))->result, messages::NavigateToPoseResult());
}

TEST_F(NavigateActionTest, WhatIsRejectedLeavesTheGoalBeforeItAlone) {
  ASSERT_TRUE(Send(1).response.accepted);
  EXPECT_THAT(Send(1).why.message(), HasSubstr("known"));
  messages::NavigateToPoseSendGoalRequest with_tree;
  with_tree.goal_id = Id(2);
  with_tree.goal.behavior_tree = "/opt/tree.xml";
  const NavigateAction::Answer tree = action_.Take(with_tree, At(1));
  EXPECT_FALSE(tree.response.accepted);
  EXPECT_THAT(tree.why.message(), HasSubstr("/opt/tree.xml"));
  refusal_ = absl::FailedPreconditionError("it is stopped");
  const NavigateAction::Answer refused = Send(3);
  EXPECT_FALSE(refused.response.accepted);
  EXPECT_EQ(refused.why, refusal_);
  EXPECT_EQ(goals_, 1U);
  EXPECT_EQ(StatusOf(1), GoalStatus::kExecuting);
  EXPECT_EQ(action_.Statuses().status_list.size(), 1U);
  EXPECT_EQ(action_.ResultOf(Id(3))->status, GoalStatus::kUnknown);
}

TEST_F(NavigateActionTest, ANewGoalAbortsTheOneBeforeIt) {
  ASSERT_TRUE(Send(1).response.accepted);
  ASSERT_TRUE(Send(2).response.accepted);
  EXPECT_EQ(StatusOf(1), GoalStatus::kAborted);
  EXPECT_EQ(StatusOf(2), GoalStatus::kExecuting);
  const auto result = action_.ResultOf(Id(1));
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->result.error_code, 0);
  EXPECT_THAT(result->result.error_msg, HasSubstr("another goal"));
  // A state that was published before the second goal was set.
  EXPECT_FALSE(Follow(1, GoalState::kSucceeded).has_value());
  EXPECT_EQ(StatusOf(2), GoalStatus::kExecuting);
  EXPECT_TRUE(Follow(2, GoalState::kActive).has_value());
}

// Of RViz, the page, a route: the numbers are the agent's own.
TEST_F(NavigateActionTest, AGoalOfSomebodyElseAbortsOurs) {
  ASSERT_TRUE(Send(1).response.accepted);
  EXPECT_FALSE(Follow(9, GoalState::kActive).has_value());
  EXPECT_EQ(StatusOf(1), GoalStatus::kAborted);
  EXPECT_EQ(action_.ResultOf(Id(1))->result.error_code, 0);
}

TEST_F(NavigateActionTest, FailuresHaveNav2sNumbersAndOurWords) {
  ASSERT_TRUE(Send(1).response.accepted);
  agent_service::AgentState state = State(1, GoalState::kFailed);
  state.snapshot.goal->cause = core::NavigationCause::kNoPath;
  state.snapshot.goal->why = "a wall all around";
  EXPECT_FALSE(action_.Follow(state, At(1), "map").has_value());
  EXPECT_EQ(action_.ResultOf(Id(1))->status, GoalStatus::kAborted);
  EXPECT_EQ(action_.ResultOf(Id(1))->result.error_code, 208);
  EXPECT_EQ(action_.ResultOf(Id(1))->result.error_msg, "a wall all around");
  EXPECT_EQ(ErrorCodeOf(core::NavigationCause::kGoalOutside), 204);
  EXPECT_EQ(ErrorCodeOf(core::NavigationCause::kStartBlocked), 205);
  EXPECT_EQ(ErrorCodeOf(core::NavigationCause::kGoalBlocked), 206);
  EXPECT_EQ(ErrorCodeOf(core::NavigationCause::kPlanTimeout), 207);
  EXPECT_EQ(ErrorCodeOf(core::NavigationCause::kNoProgress), 105);
  EXPECT_EQ(ErrorCodeOf(core::NavigationCause::kLaserLost), 100);
}

TEST_F(NavigateActionTest, CancellingIsTwoSteps) {
  ASSERT_TRUE(Send(1).response.accepted);
  const CancelGoalResponse response = Cancel(Id(1));
  EXPECT_EQ(response.return_code, CancelGoalResponse::kNone);
  ASSERT_EQ(response.goals_canceling.size(), 1U);
  EXPECT_EQ(response.goals_canceling[0].goal_id, Id(1));
  EXPECT_EQ(response.goals_canceling[0].stamp, At(0).stamp);
  EXPECT_EQ(StatusOf(1), GoalStatus::kCanceling);
  EXPECT_FALSE(action_.ResultOf(Id(1)).has_value());
  // Asked twice, it is cancelled once.
  EXPECT_EQ(Cancel(Id(1)).goals_canceling.size(), 1U);
  EXPECT_EQ(cancelled_, std::vector<uint64_t>{1});
  Follow(1, GoalState::kCancelled);
  EXPECT_EQ(action_.ResultOf(Id(1))->status, GoalStatus::kCanceled);
  EXPECT_EQ(Cancel(Id(1)).return_code, CancelGoalResponse::kGoalTerminated);
}

TEST_F(NavigateActionTest, WhichGoalsACancelMeans) {
  EXPECT_EQ(Cancel({}).return_code, CancelGoalResponse::kNone);
  EXPECT_EQ(Cancel(Id(4)).return_code, CancelGoalResponse::kUnknownGoalId);
  ASSERT_TRUE(Send(1, /*second=*/10).response.accepted);
  EXPECT_TRUE(Cancel({}, At(9).stamp).goals_canceling.empty());
  EXPECT_TRUE(Cancel(Id(4), At(9).stamp).goals_canceling.empty());
  EXPECT_TRUE(cancelled_.empty());
  EXPECT_EQ(Cancel(Id(4), At(10).stamp).goals_canceling.size(), 1U);
  ASSERT_TRUE(Send(2, 20).response.accepted);
  EXPECT_EQ(Cancel({}).goals_canceling.size(), 1U);
  EXPECT_EQ(cancelled_, (std::vector<uint64_t>{1, 2}));
}

TEST_F(NavigateActionTest, WhatCannotBeCancelledGoesOn) {
  ASSERT_TRUE(Send(1).response.accepted);
  cancel_answer_ = absl::NotFoundError("it has ended");
  EXPECT_EQ(Cancel(Id(1)).return_code, CancelGoalResponse::kRejected);
  EXPECT_EQ(StatusOf(1), GoalStatus::kExecuting);
  Follow(1, GoalState::kSucceeded);
  EXPECT_EQ(StatusOf(1), GoalStatus::kSucceeded);
}

// CANCELED is an end only of goals that a client cancelled.
TEST_F(NavigateActionTest, WhatAnOperatorCancelsIsAborted) {
  ASSERT_TRUE(Send(1).response.accepted);
  agent_service::AgentState state = State(1, GoalState::kCancelled);
  state.snapshot.goal->cause = core::NavigationCause::kCancelled;
  action_.Follow(state, At(1), "map");
  EXPECT_EQ(StatusOf(1), GoalStatus::kAborted);
  EXPECT_THAT(action_.ResultOf(Id(1))->result.error_msg,
              HasSubstr("cancelled"));
}

TEST_F(NavigateActionTest, StatusesChangeWhenGoalsDo) {
  EXPECT_TRUE(action_.TakeChanged()) << "there are none: that is told once";
  EXPECT_FALSE(action_.TakeChanged());
  ASSERT_TRUE(Send(1).response.accepted);
  EXPECT_TRUE(action_.TakeChanged());
  Follow(1, GoalState::kActive);
  EXPECT_FALSE(action_.TakeChanged());
  Follow(1, GoalState::kSucceeded);
  EXPECT_TRUE(action_.TakeChanged());
}

TEST_F(NavigateActionTest, OldGoalsAreForgotten) {
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(Send(static_cast<uint8_t>(i + 1), i).response.accepted);
  }
  EXPECT_LE(action_.Statuses().status_list.size(), kMaxEnded + 1);
  EXPECT_EQ(action_.ResultOf(Id(1))->status, GoalStatus::kUnknown);
  EXPECT_EQ(action_.ResultOf(Id(199))->status, GoalStatus::kAborted);
  // The one under way is not, however long it takes.
  Follow(200, GoalState::kActive, 10'000);
  ASSERT_EQ(action_.Statuses().status_list.size(), 1U);
  EXPECT_EQ(StatusOf(200), GoalStatus::kExecuting);
}

}  // namespace
}  // namespace treeline::navigate_action
