// The subcommands of `treeline-agent`, one per file.
#ifndef NAV_AGENT_APP_COMMANDS_H_
#define NAV_AGENT_APP_COMMANDS_H_

#include "common/cli/program.h"

namespace treeline {

Command AddLocalizeCommand(CLI::App& app);
Command AddMapCommand(CLI::App& app);
Command AddScoreTrajectoryCommand(CLI::App& app);
Command AddSimulateCommand(CLI::App& app);
Command AddTraversabilityCommand(CLI::App& app);

}  // namespace treeline

#endif  // NAV_AGENT_APP_COMMANDS_H_
