// treeline-agent plan: a way over a map, written and drawn.
#ifndef NAV_AGENT_APP_PLAN_PLAN_COMMAND_H_
#define NAV_AGENT_APP_PLAN_PLAN_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::plan_app {

cli::Command AddPlanCommand(CLI::App& app);

}  // namespace treeline::plan_app

#endif  // NAV_AGENT_APP_PLAN_PLAN_COMMAND_H_
