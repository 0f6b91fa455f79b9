// `treeline-emulator robot`
#ifndef SIMULATION_EMULATORS_APP_ROBOT_COMMAND_H_
#define SIMULATION_EMULATORS_APP_ROBOT_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::emulator_app {

cli::Command AddRobotCommand(CLI::App& app);

}  // namespace treeline::emulator_app

#endif  // SIMULATION_EMULATORS_APP_ROBOT_COMMAND_H_
