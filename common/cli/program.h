// Programs of several commands: help that fits 80 columns, exit codes that
// scripts can rely on.
#ifndef COMMON_CLI_PROGRAM_H_
#define COMMON_CLI_PROGRAM_H_

#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace CLI {
class App;
}

namespace treeline::cli {

// A subcommand adds its options to a CLI11 subcommand of `app` and returns
// what to run if the user chose it. The options live in the returned closure.
struct Command {
  CLI::App* app = nullptr;
  std::function<absl::Status(std::stop_token stop)> run;
};

// What a command of subcommands runs: the one that the user chose.
std::function<absl::Status(std::stop_token stop)> RunChosen(
    std::vector<Command> commands);

struct ProgramText {
  std::string name;
  std::string description;
};

// Parses the arguments, runs the chosen command, shows what it said. Returns
// the exit code: 0 done, 1 failed, 2 wrong usage, 130 interrupted. To be called
// once, from main().
int RunProgram(
    const ProgramText& text,
    const std::function<std::vector<Command>(CLI::App& app)>& add_commands,
    int argc, char** argv);

}  // namespace treeline::cli

#endif  // COMMON_CLI_PROGRAM_H_
