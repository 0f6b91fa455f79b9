// treeline-agent log: logs between formats.
#ifndef NAV_AGENT_APP_LOG_LOG_COMMAND_H_
#define NAV_AGENT_APP_LOG_LOG_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::log_app {

cli::Command AddLogCommand(CLI::App& app);

}  // namespace treeline::log_app

#endif  // NAV_AGENT_APP_LOG_LOG_COMMAND_H_
