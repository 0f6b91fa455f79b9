// The flags that suites share.
#ifndef NAV_AGENT_APP_SUITE_SUITE_FLAGS_H_
#define NAV_AGENT_APP_SUITE_SUITE_FLAGS_H_

#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "evaluation/suites/suite_options.h"

namespace treeline::suite_app {

// `run` is what one world and seed are called: "mission". Defaults are what the
// other arguments hold, which must outlive the command.

// --worlds and --seeds.
void AddWorldFlags(CLI::App& command, const std::string& run,
                   std::vector<std::string>& worlds, std::string& seeds);

// --robot, of suites whose robot is anybody's.
void AddRobotFlag(CLI::App& command, suites::SuiteOptions& options);

// All that suites of missions and of kidnaps have in common.
void AddSuiteFlags(CLI::App& command, const std::string& run,
                   suites::SuiteOptions& options);

}  // namespace treeline::suite_app

#endif  // NAV_AGENT_APP_SUITE_SUITE_FLAGS_H_
