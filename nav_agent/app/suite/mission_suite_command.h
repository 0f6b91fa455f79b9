// treeline-agent suite missions: does the robot get there?
#ifndef NAV_AGENT_APP_SUITE_MISSION_SUITE_COMMAND_H_
#define NAV_AGENT_APP_SUITE_MISSION_SUITE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::suite_app {

cli::Command AddMissionSuite(CLI::App& suite);

}  // namespace treeline::suite_app

#endif  // NAV_AGENT_APP_SUITE_MISSION_SUITE_COMMAND_H_
