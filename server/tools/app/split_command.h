// treeline split: frames to learn, and frames to ask about from elsewhere.
#ifndef SERVER_TOOLS_APP_SPLIT_COMMAND_H_
#define SERVER_TOOLS_APP_SPLIT_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::tools_app {

cli::Command AddSplitCommand(CLI::App& app);

}  // namespace treeline::tools_app

#endif  // SERVER_TOOLS_APP_SPLIT_COMMAND_H_
