// treeline learn: from a capture to a scene that serves, in one command.
#ifndef SERVER_TOOLS_APP_LEARN_COMMAND_H_
#define SERVER_TOOLS_APP_LEARN_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddLearnCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_LEARN_COMMAND_H_
