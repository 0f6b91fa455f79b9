// treeline inspect: what a model file says about itself.
#ifndef SERVER_TOOLS_APP_INSPECT_COMMAND_H_
#define SERVER_TOOLS_APP_INSPECT_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddInspectCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_INSPECT_COMMAND_H_
