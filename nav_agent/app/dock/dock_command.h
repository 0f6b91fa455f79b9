// treeline-agent dock: docks of a running agent, kept, driven, and ended.
#ifndef NAV_AGENT_APP_DOCK_DOCK_COMMAND_H_
#define NAV_AGENT_APP_DOCK_DOCK_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::dock_app {

cli::Command AddDockCommand(CLI::App& app);

}  // namespace treeline::dock_app

#endif  // NAV_AGENT_APP_DOCK_DOCK_COMMAND_H_
