// treeline: learn a scene from recorded frames, and measure the result.
#include <vector>

#include "CLI/CLI.hpp"
#include "server/tools/commands.h"

namespace treeline {
namespace {

constexpr const char* kDescription =
    "Treeline tells a camera where it is. This program learns scenes from "
    "recorded frames and measures how well it did.";

std::vector<Command> AddCommands(CLI::App& app) {
  return {
      AddCalibrateCommand(app), AddTrainCommand(app),
      AddEvaluateCommand(app),  AddInspectCommand(app),
      AddPublishCommand(app),   AddRecognizeCommand(app),
      AddSynthCommand(app),
  };
}

}  // namespace
}  // namespace treeline

// Exit codes are as docs/evaluation.md states them.
int main(int argc, char** argv) {
  return treeline::RunProgram({"treeline", treeline::kDescription},
                              treeline::AddCommands, argc, argv);
}
