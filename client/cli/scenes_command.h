// treeline-client scenes: what a server has.
#ifndef CLIENT_CLI_SCENES_COMMAND_H_
#define CLIENT_CLI_SCENES_COMMAND_H_

#include "client/cli/client_command.h"

namespace treeline::client_cli {

ClientCommand AddScenesCommand(CLI::App& app);

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_SCENES_COMMAND_H_
