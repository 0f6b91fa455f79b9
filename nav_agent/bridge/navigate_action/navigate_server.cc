#include "nav_agent/bridge/navigate_action/navigate_server.h"

#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/ros2/messages/message_codec.h"

namespace treeline::navigate_action {
namespace {

// rcl_action_qos_profile_status_default.
constexpr dds::Quality kStatus = {
    .is_reliable = true, .is_latched = true, .depth = 1};
constexpr size_t kMaxWaiting = 256;

}  // namespace

absl::StatusOr<std::unique_ptr<NavigateServer>> NavigateServer::Open(
    dds::Node& node, const Serve& serve, const std::string& action,
    ActionAgent agent, Warn warn) {
  std::unique_ptr<NavigateServer> server(
      new NavigateServer(std::move(agent), std::move(warn)));
  const std::string inside = action + "/_action/";
  TL_ASSIGN_OR_RETURN(
      server->feedback_,
      node.Advertise(inside + "feedback",
                     messages::NavigateToPoseFeedbackMessage::kName, {}));
  TL_ASSIGN_OR_RETURN(
      server->status_,
      node.Advertise(inside + "status", messages::GoalStatusArray::kName,
                     kStatus));
  TL_ASSIGN_OR_RETURN(
      server->cancel_goal_,
      serve(inside + "cancel_goal", "action_msgs/srv/CancelGoal"));
  TL_ASSIGN_OR_RETURN(server->get_result_,
                      serve(inside + "get_result",
                            "nav2_msgs/action/NavigateToPose_GetResult"));
  TL_ASSIGN_OR_RETURN(
      server->send_goal_,
      serve(inside + "send_goal", "nav2_msgs/action/NavigateToPose_SendGoal"));
  TL_RETURN_IF_ERROR(server->PublishStatuses());
  return server;
}

void NavigateServer::WarnOf(const dds::Service& service,
                            const absl::Status& status) {
  if (!status.ok()) {
    warn_(absl::StrCat(service.name(), ": ", status.message()));
  }
}

void NavigateServer::AnswerGoals(const Moment& moment) {
  for (const dds::Request& request : send_goal_->Take()) {
    const auto goal = messages::Decode<messages::NavigateToPoseSendGoalRequest>(
        request.bytes);
    // Who sends what cannot be read is told that it is refused.
    const NavigateAction::Answer answer =
        goal.ok()
            ? action_.Take(*goal, moment)
            : NavigateAction::Answer{.response = {}, .why = goal.status()};
    if (!answer.why.ok()) {
      warn_(absl::StrCat(send_goal_->name(),
                         ": a goal is rejected: ", answer.why.message()));
    }
    WarnOf(*send_goal_,
           send_goal_->Reply(request.id, messages::Encode(answer.response)));
  }
}

void NavigateServer::AnswerCancels() {
  for (const dds::Request& request : cancel_goal_->Take()) {
    const auto cancel =
        messages::Decode<messages::CancelGoalRequest>(request.bytes);
    messages::CancelGoalResponse response;
    response.return_code = messages::CancelGoalResponse::kRejected;
    if (cancel.ok()) response = action_.Cancel(*cancel);
    WarnOf(*cancel_goal_, cancel.status());
    WarnOf(*cancel_goal_,
           cancel_goal_->Reply(request.id, messages::Encode(response)));
  }
}

void NavigateServer::TakeResultRequests() {
  for (const dds::Request& request : get_result_->Take()) {
    const auto wanted =
        messages::Decode<messages::NavigateToPoseGetResultRequest>(
            request.bytes);
    WarnOf(*get_result_, wanted.status());
    if (!wanted.ok()) continue;
    waiting_.push_back({.id = request.id, .goal_id = wanted->goal_id});
    if (waiting_.size() > kMaxWaiting) waiting_.pop_front();
  }
}

void NavigateServer::SendResults() {
  std::deque<Waiting> waiting = std::exchange(waiting_, {});
  for (const Waiting& request : waiting) {
    const std::optional<messages::NavigateToPoseGetResultResponse> result =
        action_.ResultOf(request.goal_id);
    if (!result.has_value()) {
      waiting_.push_back(request);
      continue;
    }
    WarnOf(*get_result_,
           get_result_->Reply(request.id, messages::Encode(*result)));
  }
}

void NavigateServer::WarnOfOthers() {
  if (has_warned_of_others_ || send_goal_->not_understood() == 0) return;
  has_warned_of_others_ = true;
  warn_(absl::StrCat(
      send_goal_->name(),
      ": a client of another implementation of ROS 2 asks, which is not "
      "understood: set rmw in the robot's file to its RMW_IMPLEMENTATION"));
}

absl::Status NavigateServer::PublishStatuses() {
  if (!action_.TakeChanged()) return absl::OkStatus();
  return status_->Publish(messages::Encode(action_.Statuses()));
}

void NavigateServer::Answer(const Moment& moment) {
  AnswerGoals(moment);
  AnswerCancels();
  TakeResultRequests();
  // Before results: who hears of the end asks for the state.
  WarnOf(*send_goal_, PublishStatuses());
  SendResults();
  WarnOfOthers();
}

absl::Status NavigateServer::Tell(const agent_service::AgentState& state,
                                  const Moment& moment,
                                  const std::string& map_frame) {
  const std::optional<messages::NavigateToPoseFeedback> feedback =
      action_.Follow(state, moment, map_frame);
  TL_RETURN_IF_ERROR(PublishStatuses());
  SendResults();
  if (!feedback.has_value()) return absl::OkStatus();
  return feedback_->Publish(
      messages::Encode(messages::NavigateToPoseFeedbackMessage{
          .goal_id = action_.current_id(), .feedback = *feedback}));
}

void NavigateServer::Close(const Moment& moment) {
  action_.Abort("the agent ends", moment);
  WarnOf(*send_goal_, PublishStatuses());
  TakeResultRequests();
  SendResults();
}

}  // namespace treeline::navigate_action
