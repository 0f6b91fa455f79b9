// treeline-agent suite: experiments in simulated worlds, over many seeds.
#include <vector>

#include "CLI/CLI.hpp"
#include "nav_agent/app/commands.h"

namespace treeline {

Command AddSuiteCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "suite", "Measure the agent in simulated worlds, over many seeds");
  command->require_subcommand(1);
  const std::vector<Command> suites = {
      AddLostSuite(*command), AddLostFit(*command), AddMissionSuite(*command),
      AddKidnapSuite(*command)};
  return {command, [suites](const std::stop_token& stop) {
            for (const Command& suite : suites) {
              if (suite.app->parsed()) return suite.run(stop);
            }
            return absl::InternalError("no suite was chosen");
          }};
}

}  // namespace treeline
