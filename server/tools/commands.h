// The subcommands of `treeline`, one per file.
#ifndef SERVER_TOOLS_COMMANDS_H_
#define SERVER_TOOLS_COMMANDS_H_

#include "common/cli/program.h"

namespace treeline {

Command AddCalibrateCommand(CLI::App& app);
Command AddTrainCommand(CLI::App& app);
Command AddEvaluateCommand(CLI::App& app);
Command AddInspectCommand(CLI::App& app);
Command AddPublishCommand(CLI::App& app);
Command AddRecognizeCommand(CLI::App& app);
Command AddSynthCommand(CLI::App& app);

}  // namespace treeline

#endif  // SERVER_TOOLS_COMMANDS_H_
