#include "nav_agent/app/suite/suite_command.h"

#include <vector>

#include "CLI/CLI.hpp"
#include "nav_agent/app/suite/field_suite_command.h"
#include "nav_agent/app/suite/kidnap_suite_command.h"
#include "nav_agent/app/suite/lost_suite_command.h"
#include "nav_agent/app/suite/mission_suite_command.h"

namespace treeline::suite_app {

cli::Command AddSuiteCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "suite", "Measure the agent in simulated worlds, over many seeds");
  command->require_subcommand(1);
  const std::vector<cli::Command> suites = {
      AddLostSuite(*command), AddLostFit(*command), AddMissionSuite(*command),
      AddKidnapSuite(*command), AddFieldSuite(*command)};
  return {command, [suites](const std::stop_token& stop) {
            for (const cli::Command& suite : suites) {
              if (suite.app->parsed()) return suite.run(stop);
            }
            return absl::InternalError("no suite was chosen");
          }};
}

}  // namespace treeline::suite_app
