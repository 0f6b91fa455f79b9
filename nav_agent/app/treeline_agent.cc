// treeline-agent: the robot's half of Treeline.
#include <vector>

#include "CLI/CLI.hpp"
#include "nav_agent/app/commands.h"

namespace treeline {
namespace {

constexpr const char* kDescription =
    "Treeline's robot: maps, knows where it is, and drives. This program runs "
    "it, in the world or in a simulated one.";

std::vector<Command> AddCommands(CLI::App& app) {
  return {AddSimulateCommand(app),
          AddMapCommand(app),
          AddRunCommand(app),
          AddNavigateCommand(app),
          AddDoctorCommand(app),
          AddPlanCommand(app),
          AddLocalizeCommand(app),
          AddTraversabilityCommand(app),
          AddScoreTrajectoryCommand(app),
          AddSuiteCommand(app)};
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  return treeline::RunProgram({"treeline-agent", treeline::kDescription},
                              treeline::AddCommands, argc, argv);
}
