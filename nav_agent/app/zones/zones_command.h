// treeline-agent zones: drawn zones of a running agent.
#ifndef NAV_AGENT_APP_ZONES_ZONES_COMMAND_H_
#define NAV_AGENT_APP_ZONES_ZONES_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::zones_app {

cli::Command AddZonesCommand(CLI::App& app);

}  // namespace treeline::zones_app

#endif  // NAV_AGENT_APP_ZONES_ZONES_COMMAND_H_
