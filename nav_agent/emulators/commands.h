// The subcommands of `treeline-emulator`, one per device and file.
#ifndef NAV_AGENT_EMULATORS_COMMANDS_H_
#define NAV_AGENT_EMULATORS_COMMANDS_H_

#include "common/cli/program.h"

namespace treeline {

Command AddBaseCommand(CLI::App& app);
Command AddLaserCommand(CLI::App& app);
Command AddRobotCommand(CLI::App& app);

}  // namespace treeline

#endif  // NAV_AGENT_EMULATORS_COMMANDS_H_
