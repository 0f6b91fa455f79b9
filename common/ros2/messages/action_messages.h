// Messages of unique_identifier_msgs and action_msgs, and those that make the
// action nav2_msgs/action/NavigateToPose on the wire
// (https://design.ros2.org/articles/actions.html).
#ifndef COMMON_ROS2_MESSAGES_ACTION_MESSAGES_H_
#define COMMON_ROS2_MESSAGES_ACTION_MESSAGES_H_

#include <array>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/message_fields.h"

namespace treeline::messages {

struct Uuid {
  std::array<uint8_t, 16> uuid = {};

  bool operator==(const Uuid&) const = default;
  static constexpr char kName[] = "unique_identifier_msgs/msg/UUID";
  static constexpr auto Fields() {
    return std::make_tuple(Named("uuid", &Uuid::uuid));
  }
};

// nanosec is below 1e9 and counts forwards, also where sec is negative.
struct Duration {
  int32_t sec = 0;
  uint32_t nanosec = 0;

  bool operator==(const Duration&) const = default;
  static constexpr char kName[] = "builtin_interfaces/msg/Duration";
  static constexpr auto Fields() {
    return std::make_tuple(Named("sec", &Duration::sec),
                           Named("nanosec", &Duration::nanosec));
  }
};

// stamp: when the goal was accepted.
struct GoalInfo {
  Uuid goal_id;
  Time stamp;

  bool operator==(const GoalInfo&) const = default;
  static constexpr char kName[] = "action_msgs/msg/GoalInfo";
  static constexpr auto Fields() {
    return std::make_tuple(Named("goal_id", &GoalInfo::goal_id),
                           Named("stamp", &GoalInfo::stamp));
  }
};

struct GoalStatus {
  static constexpr int8_t kUnknown = 0;
  static constexpr int8_t kAccepted = 1;
  static constexpr int8_t kExecuting = 2;
  static constexpr int8_t kCanceling = 3;
  static constexpr int8_t kSucceeded = 4;
  static constexpr int8_t kCanceled = 5;
  static constexpr int8_t kAborted = 6;

  GoalInfo goal_info;
  int8_t status = kUnknown;

  bool operator==(const GoalStatus&) const = default;
  static constexpr char kName[] = "action_msgs/msg/GoalStatus";
  static constexpr auto Fields() {
    return std::make_tuple(Named("goal_info", &GoalStatus::goal_info),
                           Named("status", &GoalStatus::status));
  }
};

struct GoalStatusArray {
  std::vector<GoalStatus> status_list;

  bool operator==(const GoalStatusArray&) const = default;
  static constexpr char kName[] = "action_msgs/msg/GoalStatusArray";
  static constexpr auto Fields() {
    return std::make_tuple(Named("status_list", &GoalStatusArray::status_list));
  }
};

// An id of zeros: all goals; with a stamp, those accepted until then, and the
// one that is named.
struct CancelGoalRequest {
  GoalInfo goal_info;

  bool operator==(const CancelGoalRequest&) const = default;
  static constexpr char kName[] = "action_msgs/srv/CancelGoal_Request";
  static constexpr auto Fields() {
    return std::make_tuple(Named("goal_info", &CancelGoalRequest::goal_info));
  }
};

struct CancelGoalResponse {
  static constexpr int8_t kNone = 0;
  static constexpr int8_t kRejected = 1;
  static constexpr int8_t kUnknownGoalId = 2;
  static constexpr int8_t kGoalTerminated = 3;

  int8_t return_code = kNone;
  std::vector<GoalInfo> goals_canceling;

  bool operator==(const CancelGoalResponse&) const = default;
  static constexpr char kName[] = "action_msgs/srv/CancelGoal_Response";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("return_code", &CancelGoalResponse::return_code),
        Named("goals_canceling", &CancelGoalResponse::goals_canceling));
  }
};

// behavior_tree: a file of Nav2's, or "".
struct NavigateToPoseGoal {
  PoseStamped pose;
  std::string behavior_tree;

  bool operator==(const NavigateToPoseGoal&) const = default;
  static constexpr char kName[] = "nav2_msgs/action/NavigateToPose_Goal";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("pose", &NavigateToPoseGoal::pose),
        Named("behavior_tree", &NavigateToPoseGoal::behavior_tree));
  }
};

struct NavigateToPoseSendGoalRequest {
  Uuid goal_id;
  NavigateToPoseGoal goal;

  bool operator==(const NavigateToPoseSendGoalRequest&) const = default;
  static constexpr char kName[] =
      "nav2_msgs/action/NavigateToPose_SendGoal_Request";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("goal_id", &NavigateToPoseSendGoalRequest::goal_id),
        Named("goal", &NavigateToPoseSendGoalRequest::goal));
  }
};

struct NavigateToPoseSendGoalResponse {
  bool accepted = false;
  Time stamp;

  bool operator==(const NavigateToPoseSendGoalResponse&) const = default;
  static constexpr char kName[] =
      "nav2_msgs/action/NavigateToPose_SendGoal_Response";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("accepted", &NavigateToPoseSendGoalResponse::accepted),
        Named("stamp", &NavigateToPoseSendGoalResponse::stamp));
  }
};

struct NavigateToPoseGetResultRequest {
  Uuid goal_id;

  bool operator==(const NavigateToPoseGetResultRequest&) const = default;
  static constexpr char kName[] =
      "nav2_msgs/action/NavigateToPose_GetResult_Request";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("goal_id", &NavigateToPoseGetResultRequest::goal_id));
  }
};

// As Jazzy has it. What others have are beginnings of these bytes: Iron's
// error_code alone, and Humble's std_msgs/Empty, a byte where the padding of
// error_code is.
struct NavigateToPoseResult {
  uint16_t error_code = 0;
  std::string error_msg;

  bool operator==(const NavigateToPoseResult&) const = default;
  static constexpr char kName[] = "nav2_msgs/action/NavigateToPose_Result";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("error_code", &NavigateToPoseResult::error_code),
        Named("error_msg", &NavigateToPoseResult::error_msg));
  }
};

// status: GoalStatus's.
struct NavigateToPoseGetResultResponse {
  int8_t status = GoalStatus::kUnknown;
  NavigateToPoseResult result;

  bool operator==(const NavigateToPoseGetResultResponse&) const = default;
  static constexpr char kName[] =
      "nav2_msgs/action/NavigateToPose_GetResult_Response";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("status", &NavigateToPoseGetResultResponse::status),
        Named("result", &NavigateToPoseGetResultResponse::result));
  }
};

// distance_remaining in m.
struct NavigateToPoseFeedback {
  PoseStamped current_pose;
  Duration navigation_time;
  Duration estimated_time_remaining;
  int16_t number_of_recoveries = 0;
  float distance_remaining = 0;

  bool operator==(const NavigateToPoseFeedback&) const = default;
  static constexpr char kName[] = "nav2_msgs/action/NavigateToPose_Feedback";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("current_pose", &NavigateToPoseFeedback::current_pose),
        Named("navigation_time", &NavigateToPoseFeedback::navigation_time),
        Named("estimated_time_remaining",
              &NavigateToPoseFeedback::estimated_time_remaining),
        Named("number_of_recoveries",
              &NavigateToPoseFeedback::number_of_recoveries),
        Named("distance_remaining",
              &NavigateToPoseFeedback::distance_remaining));
  }
};

struct NavigateToPoseFeedbackMessage {
  Uuid goal_id;
  NavigateToPoseFeedback feedback;

  bool operator==(const NavigateToPoseFeedbackMessage&) const = default;
  static constexpr char kName[] =
      "nav2_msgs/action/NavigateToPose_FeedbackMessage";
  static constexpr auto Fields() {
    return std::make_tuple(
        Named("goal_id", &NavigateToPoseFeedbackMessage::goal_id),
        Named("feedback", &NavigateToPoseFeedbackMessage::feedback));
  }
};

}  // namespace treeline::messages

#endif  // COMMON_ROS2_MESSAGES_ACTION_MESSAGES_H_
