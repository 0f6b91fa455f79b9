// treeline shrink: a model made smaller.
#ifndef SERVER_TOOLS_APP_SHRINK_COMMAND_H_
#define SERVER_TOOLS_APP_SHRINK_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddShrinkCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_SHRINK_COMMAND_H_
