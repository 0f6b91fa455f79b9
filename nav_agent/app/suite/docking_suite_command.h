// `treeline-agent suite docking`.
#ifndef NAV_AGENT_APP_SUITE_DOCKING_SUITE_COMMAND_H_
#define NAV_AGENT_APP_SUITE_DOCKING_SUITE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::suite_app {

cli::Command AddDockingSuite(CLI::App& suite);

}  // namespace treeline::suite_app

#endif  // NAV_AGENT_APP_SUITE_DOCKING_SUITE_COMMAND_H_
