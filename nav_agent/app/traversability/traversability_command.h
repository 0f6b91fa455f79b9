// treeline-agent traversability: where a robot may drive, from an OctoMap.
#ifndef NAV_AGENT_APP_TRAVERSABILITY_TRAVERSABILITY_COMMAND_H_
#define NAV_AGENT_APP_TRAVERSABILITY_TRAVERSABILITY_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::traversability_app {

cli::Command AddTraversabilityCommand(CLI::App& app);

}  // namespace treeline::traversability_app

#endif  // NAV_AGENT_APP_TRAVERSABILITY_TRAVERSABILITY_COMMAND_H_
