// treeline-agent navigate: sends a running agent somewhere.
#ifndef NAV_AGENT_APP_NAVIGATE_NAVIGATE_COMMAND_H_
#define NAV_AGENT_APP_NAVIGATE_NAVIGATE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::navigate_app {

cli::Command AddNavigateCommand(CLI::App& app);

}  // namespace treeline::navigate_app

#endif  // NAV_AGENT_APP_NAVIGATE_NAVIGATE_COMMAND_H_
