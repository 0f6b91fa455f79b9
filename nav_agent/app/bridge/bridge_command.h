// treeline-agent bridge: among the nodes of a robot that runs ROS 2.
#ifndef NAV_AGENT_APP_BRIDGE_BRIDGE_COMMAND_H_
#define NAV_AGENT_APP_BRIDGE_BRIDGE_COMMAND_H_

#include "common/cli/program.h"
#include "nav_agent/app/bridge/bridge_config.h"

namespace treeline::bridge_app {

// `read_sensors`: of the robots' files that there are.
cli::Command AddBridgeCommand(CLI::App& app, SensorsReader read_sensors);

}  // namespace treeline::bridge_app

#endif  // NAV_AGENT_APP_BRIDGE_BRIDGE_COMMAND_H_
