// treeline-agent run: a robot that takes goals.
#ifndef NAV_AGENT_APP_RUN_RUN_COMMAND_H_
#define NAV_AGENT_APP_RUN_RUN_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::run_app {

cli::Command AddRunCommand(CLI::App& app);

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_RUN_COMMAND_H_
