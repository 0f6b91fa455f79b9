// treeline-client: asks a Treeline server, from a shell.
#include <optional>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "client/cli/bench_command.h"
#include "client/cli/client_command.h"
#include "client/cli/localize_command.h"
#include "client/cli/scenes_command.h"
#include "client/cli/watch_command.h"
#include "common/base/interrupt.h"
#include "common/base/version.h"
#include "common/cli/arguments.h"

namespace treeline::client_cli {
namespace {

constexpr const char* kFooter = R"(
treeline-client COMMAND --help explains a command and gives examples.

Exit codes: 0 done, 1 failed, 2 wrong usage, 3 not localized, 4
a condition of bench --fail-if holds, 130 interrupted.)";

int Run(int argc, char** argv) {
  const std::stop_token stop = base::StopOnInterrupt();
  CLI::App app("Asks a Treeline server where a camera is.", "treeline-client");
  app.formatter(cli::HelpFormatter());
  app.footer(kFooter);
  app.set_version_flag("--version",
                       std::string("treeline-client ") + base::Version());
  app.require_subcommand(1);
  const std::vector<ClientCommand> commands = {
      AddLocalizeCommand(app), AddScenesCommand(app), AddBenchCommand(app),
      AddWatchCommand(app)};
  if (const std::optional<int> exit_code =
          cli::ParseArguments(app, argc, argv)) {
    return *exit_code;
  }
  for (const ClientCommand& command : commands) {
    if (command.app->parsed()) return command.run(stop);
  }
  return kExitUsage;
}

}  // namespace
}  // namespace treeline::client_cli

int main(int argc, char** argv) {
  return treeline::client_cli::Run(argc, argv);
}
