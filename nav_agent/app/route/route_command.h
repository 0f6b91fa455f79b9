// treeline-agent route: routes of a running agent, kept, driven, and ended.
#ifndef NAV_AGENT_APP_ROUTE_ROUTE_COMMAND_H_
#define NAV_AGENT_APP_ROUTE_ROUTE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::route_app {

cli::Command AddRouteCommand(CLI::App& app);

}  // namespace treeline::route_app

#endif  // NAV_AGENT_APP_ROUTE_ROUTE_COMMAND_H_
