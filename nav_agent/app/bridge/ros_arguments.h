// What `ros2 launch` and `ros2 run` write behind --ros-args.
#ifndef NAV_AGENT_APP_BRIDGE_ROS_ARGUMENTS_H_
#define NAV_AGENT_APP_BRIDGE_ROS_ARGUMENTS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace treeline::bridge_app {

// Arguments of the program, its own name first, with what stands between
// --ros-args and -- (or the end) as the flags of `bridge`: -r __ns:=, __node:=
// and FROM:=TO, -p NAME:=VALUE, --params-file, --log-level
// (https://design.ros2.org/articles/ros_command_line_arguments.html). Without
// --ros-args they stay as they are. INVALID_ARGUMENT for what has no flag here,
// and for other commands: they have a file.
absl::StatusOr<std::vector<std::string>> WithoutRosArguments(
    const std::vector<std::string>& arguments);

}  // namespace treeline::bridge_app

#endif  // NAV_AGENT_APP_BRIDGE_ROS_ARGUMENTS_H_
