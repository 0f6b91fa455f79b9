// treeline-emulator: devices that a robot is made of, byte for byte, for
// drivers that want to be tested, and a robot of ROS 2.
#include <vector>

#include "CLI/CLI.hpp"
#include "simulation/emulators/app/base_command.h"
#include "simulation/emulators/app/laser_command.h"
#include "simulation/emulators/app/robot_command.h"
#include "simulation/emulators/app/ros2_command.h"

namespace treeline::emulator_app {
namespace {

constexpr const char* kDescription =
    "Devices that a robot is made of, played by a program: what they send and "
    "understand, byte for byte, over a pseudo terminal or TCP, and a whole "
    "robot that speaks ROS 2. Drivers cannot tell the difference. Ctrl-C stops "
    "it.";

std::vector<cli::Command> AddCommands(CLI::App& app) {
  return {AddLaserCommand(app), AddBaseCommand(app), AddRobotCommand(app),
          AddRos2Command(app)};
}

}  // namespace
}  // namespace treeline::emulator_app

int main(int argc, char** argv) {
  return treeline::cli::RunProgram(
      {"treeline-emulator", treeline::emulator_app::kDescription},
      treeline::emulator_app::AddCommands, argc, argv);
}
