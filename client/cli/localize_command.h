// treeline-client localize: where was this taken?
#ifndef CLIENT_CLI_LOCALIZE_COMMAND_H_
#define CLIENT_CLI_LOCALIZE_COMMAND_H_

#include "client/cli/client_command.h"

namespace treeline::client_cli {

ClientCommand AddLocalizeCommand(CLI::App& app);

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_LOCALIZE_COMMAND_H_
