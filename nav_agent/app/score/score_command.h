// treeline-agent score-trajectory: how good is a trajectory?
#ifndef NAV_AGENT_APP_SCORE_SCORE_COMMAND_H_
#define NAV_AGENT_APP_SCORE_SCORE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::score_app {

cli::Command AddScoreTrajectoryCommand(CLI::App& app);

}  // namespace treeline::score_app

#endif  // NAV_AGENT_APP_SCORE_SCORE_COMMAND_H_
