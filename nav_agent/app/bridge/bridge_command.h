// treeline-agent bridge: among the nodes of a robot that runs ROS 2.
#ifndef NAV_AGENT_APP_BRIDGE_BRIDGE_COMMAND_H_
#define NAV_AGENT_APP_BRIDGE_BRIDGE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::bridge_app {

cli::Command AddBridgeCommand(CLI::App& app);

}  // namespace treeline::bridge_app

#endif  // NAV_AGENT_APP_BRIDGE_BRIDGE_COMMAND_H_
