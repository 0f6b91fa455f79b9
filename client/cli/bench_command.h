// treeline-client bench: how much a server takes, and whether it stays right.
#ifndef CLIENT_CLI_BENCH_COMMAND_H_
#define CLIENT_CLI_BENCH_COMMAND_H_

#include "client/cli/client_command.h"

namespace treeline::client_cli {

ClientCommand AddBenchCommand(CLI::App& app);

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_BENCH_COMMAND_H_
