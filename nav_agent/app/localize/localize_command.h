// treeline-agent localize: AMCL over a recording.
#ifndef NAV_AGENT_APP_LOCALIZE_LOCALIZE_COMMAND_H_
#define NAV_AGENT_APP_LOCALIZE_LOCALIZE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::localize_app {

cli::Command AddLocalizeCommand(CLI::App& app);

}  // namespace treeline::localize_app

#endif  // NAV_AGENT_APP_LOCALIZE_LOCALIZE_COMMAND_H_
