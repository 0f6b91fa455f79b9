// The measures of a robot as text, for a recording that others open.
#ifndef NAV_AGENT_ROS_LOG_ROBOT_TEXT_H_
#define NAV_AGENT_ROS_LOG_ROBOT_TEXT_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/core/robot_model.h"

namespace treeline::ros_log {

// "front_m: 0.3" and so on, a line each; where sensors are is left out: /tf
// tells it.
std::string RobotText(const core::RobotModel& robot);
// The inverse; what is not named keeps its default. INVALID_ARGUMENT for
// anything else, and for what is no robot.
absl::StatusOr<core::RobotModel> ParseRobotText(absl::string_view text);

}  // namespace treeline::ros_log

#endif  // NAV_AGENT_ROS_LOG_ROBOT_TEXT_H_
