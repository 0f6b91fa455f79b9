// `treeline-emulator laser`
#ifndef SIMULATION_EMULATORS_APP_LASER_COMMAND_H_
#define SIMULATION_EMULATORS_APP_LASER_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::emulator_app {

cli::Command AddLaserCommand(CLI::App& app);

}  // namespace treeline::emulator_app

#endif  // SIMULATION_EMULATORS_APP_LASER_COMMAND_H_
