// treeline: learn a scene from recorded frames, and measure the result.
#include <vector>

#include "CLI/CLI.hpp"
#include "server/tools/app/calibrate_command.h"
#include "server/tools/app/evaluate_command.h"
#include "server/tools/app/import_command.h"
#include "server/tools/app/inspect_command.h"
#include "server/tools/app/learn_command.h"
#include "server/tools/app/publish_command.h"
#include "server/tools/app/recognize_command.h"
#include "server/tools/app/shrink_command.h"
#include "server/tools/app/split_command.h"
#include "server/tools/app/synth_command.h"
#include "server/tools/app/train_command.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kDescription =
    "Treeline tells a camera where it is. This program learns scenes from "
    "recorded frames and measures how well it did.";

std::vector<cli::Command> AddCommands(CLI::App& app) {
  return {
      AddLearnCommand(app),   AddImportCommand(app),  AddCalibrateCommand(app),
      AddTrainCommand(app),   AddMergeCommand(app),   AddEvaluateCommand(app),
      AddInspectCommand(app), AddPublishCommand(app), AddRecognizeCommand(app),
      AddSplitCommand(app),   AddSynthCommand(app),   AddShrinkCommand(app),
  };
}

}  // namespace
}  // namespace treeline::tools_app

// Exit codes are as docs/reference/evaluation.md states them.
int main(int argc, char** argv) {
  return treeline::cli::RunProgram(
      {"treeline", treeline::tools_app::kDescription},
      treeline::tools_app::AddCommands, argc, argv);
}
