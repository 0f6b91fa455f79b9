// `treeline-emulator ros2`.
#ifndef SIMULATION_EMULATORS_APP_ROS2_COMMAND_H_
#define SIMULATION_EMULATORS_APP_ROS2_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::emulator_app {

cli::Command AddRos2Command(CLI::App& app);

}  // namespace treeline::emulator_app

#endif  // SIMULATION_EMULATORS_APP_ROS2_COMMAND_H_
