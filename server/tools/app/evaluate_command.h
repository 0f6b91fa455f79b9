// treeline evaluate: localize a recording, and say how well it went.
#ifndef SERVER_TOOLS_APP_EVALUATE_COMMAND_H_
#define SERVER_TOOLS_APP_EVALUATE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddEvaluateCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_EVALUATE_COMMAND_H_
