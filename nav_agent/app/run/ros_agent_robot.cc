#include "nav_agent/app/run/ros_agent_robot.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::run_app {

absl::StatusOr<std::unique_ptr<RosAgentRobot>> RosAgentRobot::Open(
    const std::string& config_path, const base::Clock& real_clock,
    ros_app::RosRobot::Warn warn,
    const std::function<void(const std::string& line)>& announce) {
  TL_ASSIGN_OR_RETURN(const ros_app::RosRobotConfig config,
                      ros_app::ReadRosRobotConfig(config_path));
  TL_ASSIGN_OR_RETURN(std::unique_ptr<ros_app::RosRobot> robot,
                      ros_app::RosRobot::Open(config, /*drives=*/true,
                                              real_clock, std::move(warn)));
  announce(absl::StrCat("ros2 in domain ", robot->domain().id()));
  return std::unique_ptr<RosAgentRobot>(new RosAgentRobot(std::move(robot)));
}

}  // namespace treeline::run_app
