// treeline-agent robot: files that describe robots.
#ifndef NAV_AGENT_APP_ROBOT_ROBOT_COMMAND_H_
#define NAV_AGENT_APP_ROBOT_ROBOT_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::robot_app {

cli::Command AddRobotCommand(CLI::App& app);

}  // namespace treeline::robot_app

#endif  // NAV_AGENT_APP_ROBOT_ROBOT_COMMAND_H_
