// `treeline-agent suite barn`.
#ifndef NAV_AGENT_APP_SUITE_FIELD_SUITE_COMMAND_H_
#define NAV_AGENT_APP_SUITE_FIELD_SUITE_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::suite_app {

cli::Command AddFieldSuite(CLI::App& suite);

}  // namespace treeline::suite_app

#endif  // NAV_AGENT_APP_SUITE_FIELD_SUITE_COMMAND_H_
