// treeline recognize: how often the right scene is found among many.
#ifndef SERVER_TOOLS_APP_RECOGNIZE_COMMAND_H_
#define SERVER_TOOLS_APP_RECOGNIZE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddRecognizeCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_RECOGNIZE_COMMAND_H_
