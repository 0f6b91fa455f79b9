// What the subcommands of `treeline-client` have in common.
#ifndef CLIENT_CLI_CLIENT_COMMAND_H_
#define CLIENT_CLI_CLIENT_COMMAND_H_

#include <functional>
#include <stop_token>

namespace CLI {
class App;
}

namespace treeline::client_cli {

// Exit codes, as docs/reference/client.md states them.
enum ExitCode {
  kExitLocalized = 0,
  kExitFailed = 1,
  kExitUsage = 2,
  kExitNotLocalized = 3,
  kExitConditionHolds = 4,  // of bench --fail-if
  kExitInterrupted = 130
};

// A subcommand adds its options to a CLI11 subcommand of `app` and returns
// what to run if the user chose it, which returns the exit code.
struct ClientCommand {
  CLI::App* app = nullptr;
  std::function<int(std::stop_token stop)> run;
};

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_CLIENT_COMMAND_H_
