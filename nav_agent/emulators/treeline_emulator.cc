// treeline-emulator: devices that a robot is made of, byte for byte, for
// drivers that want to be tested.
#include <vector>

#include "CLI/CLI.hpp"
#include "nav_agent/emulators/commands.h"

namespace treeline {
namespace {

constexpr const char* kDescription =
    "Devices that a robot is made of, played by a program: what they send and "
    "understand, byte for byte, over a pseudo terminal or TCP. Drivers cannot "
    "tell the difference. Ctrl-C stops it.";

std::vector<Command> AddCommands(CLI::App& app) {
  return {AddLaserCommand(app), AddBaseCommand(app), AddRobotCommand(app)};
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  return treeline::RunProgram({"treeline-emulator", treeline::kDescription},
                              treeline::AddCommands, argc, argv);
}
