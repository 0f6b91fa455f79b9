// The subcommands of `treeline-agent`, one per file.
#ifndef NAV_AGENT_APP_COMMANDS_H_
#define NAV_AGENT_APP_COMMANDS_H_

#include "common/cli/program.h"

namespace treeline {

Command AddDoctorCommand(CLI::App& app);
Command AddLocalizeCommand(CLI::App& app);
Command AddMapCommand(CLI::App& app);
Command AddNavigateCommand(CLI::App& app);
Command AddRunCommand(CLI::App& app);
Command AddPlanCommand(CLI::App& app);
Command AddScoreTrajectoryCommand(CLI::App& app);
Command AddSimulateCommand(CLI::App& app);
Command AddSuiteCommand(CLI::App& app);
Command AddTraversabilityCommand(CLI::App& app);

// Those of `treeline-agent suite`.
Command AddLostSuite(CLI::App& suite);
Command AddLostFit(CLI::App& suite);
Command AddMissionSuite(CLI::App& suite);
Command AddKidnapSuite(CLI::App& suite);

}  // namespace treeline

#endif  // NAV_AGENT_APP_COMMANDS_H_
