// treeline-agent suite lost, lost-fit: how good the lost detector is, and its
// calibration.
#ifndef NAV_AGENT_APP_SUITE_LOST_SUITE_COMMAND_H_
#define NAV_AGENT_APP_SUITE_LOST_SUITE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::suite_app {

cli::Command AddLostSuite(CLI::App& suite);
cli::Command AddLostFit(CLI::App& suite);

}  // namespace treeline::suite_app

#endif  // NAV_AGENT_APP_SUITE_LOST_SUITE_COMMAND_H_
