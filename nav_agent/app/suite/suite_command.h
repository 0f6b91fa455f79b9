// treeline-agent suite: experiments in simulated worlds, over many seeds.
#ifndef NAV_AGENT_APP_SUITE_SUITE_COMMAND_H_
#define NAV_AGENT_APP_SUITE_SUITE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::suite_app {

cli::Command AddSuiteCommand(CLI::App& app);

}  // namespace treeline::suite_app

#endif  // NAV_AGENT_APP_SUITE_SUITE_COMMAND_H_
