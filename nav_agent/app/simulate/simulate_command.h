// treeline-agent simulate: a robot in a world that exists only here.
#ifndef NAV_AGENT_APP_SIMULATE_SIMULATE_COMMAND_H_
#define NAV_AGENT_APP_SIMULATE_SIMULATE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::simulate_app {

cli::Command AddSimulateCommand(CLI::App& app);

}  // namespace treeline::simulate_app

#endif  // NAV_AGENT_APP_SIMULATE_SIMULATE_COMMAND_H_
