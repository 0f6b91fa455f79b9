#include "common/cli/program.h"

#include <cstdio>
#include <optional>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/interrupt.h"
#include "common/base/version.h"
#include "common/cli/arguments.h"

namespace treeline::cli {
namespace {

constexpr int kOk = 0;
constexpr int kFailed = 1;
constexpr int kUsage = 2;
constexpr int kInterrupted = 130;

// Shows what a subcommand said, and returns the exit code for it.
int Finish(const std::string& command, const absl::Status& status) {
  if (status.ok()) {
    // A full disk or a closed pipe shows itself only here.
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return kOk;
    std::fprintf(stderr, "%s: writing standard output failed\n",
                 command.c_str());
    return kFailed;
  }
  if (status.code() == absl::StatusCode::kCancelled) {
    std::fprintf(stderr, "%s: interrupted\n", command.c_str());
    return kInterrupted;
  }
  std::fprintf(stderr, "%s: %s\n", command.c_str(),
               std::string(status.message()).c_str());
  return kFailed;
}

// "treeline-agent log convert": the commands that were chosen, too.
std::string ChosenName(const CLI::App& app) {
  std::string name = app.get_name();
  const CLI::App* chosen = &app;
  while (!chosen->get_subcommands().empty()) {
    chosen = chosen->get_subcommands().front();
    absl::StrAppend(&name, " ", chosen->get_name());
  }
  return name;
}

}  // namespace

std::function<absl::Status(std::stop_token stop)> RunChosen(
    std::vector<Command> commands) {
  return [commands = std::move(commands)](const std::stop_token& stop) {
    for (const Command& command : commands) {
      if (command.app->parsed()) return command.run(stop);
    }
    return absl::InternalError("no command was chosen");
  };
}

int RunProgram(
    const ProgramText& text,
    const std::function<std::vector<Command>(CLI::App& app)>& add_commands,
    int argc, char** argv) {
  const std::stop_token stop = base::StopOnInterrupt();
  CLI::App app(text.description, text.name);
  app.formatter(HelpFormatter());
  app.footer(absl::StrCat(
      "\n", text.name,
      " COMMAND --help explains a command and gives examples.\n\n"
      "Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted."));
  app.set_version_flag("--version",
                       absl::StrCat(text.name, " ", base::Version()));
  app.require_subcommand(1);
  const std::vector<Command> commands = add_commands(app);
  if (const std::optional<int> exit_code = ParseArguments(app, argc, argv)) {
    return *exit_code;
  }
  for (const Command& command : commands) {
    if (command.app->parsed()) {
      return Finish(ChosenName(app), command.run(stop));
    }
  }
  return kUsage;
}

}  // namespace treeline::cli
