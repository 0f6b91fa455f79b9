#include "nav_agent/app/suite/suite_command.h"

#include "CLI/CLI.hpp"
#include "nav_agent/app/suite/docking_suite_command.h"
#include "nav_agent/app/suite/field_suite_command.h"
#include "nav_agent/app/suite/kidnap_suite_command.h"
#include "nav_agent/app/suite/lost_suite_command.h"
#include "nav_agent/app/suite/mission_suite_command.h"

namespace treeline::suite_app {

cli::Command AddSuiteCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "suite", "Measure the agent in simulated worlds, over many seeds");
  command->require_subcommand(1);
  return {command,
          cli::RunChosen({AddLostSuite(*command), AddLostFit(*command),
                          AddMissionSuite(*command), AddKidnapSuite(*command),
                          AddFieldSuite(*command), AddDockingSuite(*command)})};
}

}  // namespace treeline::suite_app
