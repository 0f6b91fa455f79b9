// treeline-agent map: a drive in, a map bundle out.
#ifndef NAV_AGENT_APP_MAP_MAP_COMMAND_H_
#define NAV_AGENT_APP_MAP_MAP_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::map_app {

cli::Command AddMapCommand(CLI::App& app);

}  // namespace treeline::map_app

#endif  // NAV_AGENT_APP_MAP_MAP_COMMAND_H_
