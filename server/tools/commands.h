// The subcommands of `treeline`, one per file.
#ifndef SERVER_TOOLS_COMMANDS_H_
#define SERVER_TOOLS_COMMANDS_H_

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace CLI {
class App;
}

namespace treeline {

// A subcommand adds its options to a CLI11 subcommand of `app` and returns
// what to run if the user chose it. The options live in the returned closure.
struct Command {
  CLI::App* app = nullptr;
  std::function<absl::Status(std::stop_token stop)> run;
};

Command AddCalibrateCommand(CLI::App& app);
Command AddTrainCommand(CLI::App& app);
Command AddEvaluateCommand(CLI::App& app);
Command AddInspectCommand(CLI::App& app);
Command AddPublishCommand(CLI::App& app);
Command AddRecognizeCommand(CLI::App& app);
Command AddSynthCommand(CLI::App& app);

}  // namespace treeline

#endif  // SERVER_TOOLS_COMMANDS_H_
