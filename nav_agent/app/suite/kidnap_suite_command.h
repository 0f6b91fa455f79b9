// treeline-agent suite kidnaps: does a robot that was carried away find itself?
#ifndef NAV_AGENT_APP_SUITE_KIDNAP_SUITE_COMMAND_H_
#define NAV_AGENT_APP_SUITE_KIDNAP_SUITE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::suite_app {

cli::Command AddKidnapSuite(CLI::App& suite);

}  // namespace treeline::suite_app

#endif  // NAV_AGENT_APP_SUITE_KIDNAP_SUITE_COMMAND_H_
