// `treeline-client watch`: a live view of a server.
#ifndef CLIENT_CLI_WATCH_COMMAND_H_
#define CLIENT_CLI_WATCH_COMMAND_H_

#include "client/cli/client_command.h"

namespace treeline::client_cli {

ClientCommand AddWatchCommand(CLI::App& app);

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_WATCH_COMMAND_H_
