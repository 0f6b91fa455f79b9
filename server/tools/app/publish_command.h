// treeline publish: the index of a folder of models, for a web server.
#ifndef SERVER_TOOLS_APP_PUBLISH_COMMAND_H_
#define SERVER_TOOLS_APP_PUBLISH_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddPublishCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_PUBLISH_COMMAND_H_
