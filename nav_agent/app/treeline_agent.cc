// treeline-agent: the robot's half of Treeline.
#include <cstdio>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "nav_agent/app/bridge/bridge_command.h"
#include "nav_agent/app/bridge/ros_arguments.h"
#include "nav_agent/app/calibrate/calibrate_command.h"
#include "nav_agent/app/dock/dock_command.h"
#include "nav_agent/app/doctor/doctor_command.h"
#include "nav_agent/app/localize/localize_command.h"
#include "nav_agent/app/log/log_command.h"
#include "nav_agent/app/map/map_command.h"
#include "nav_agent/app/navigate/navigate_command.h"
#include "nav_agent/app/plan/plan_command.h"
#include "nav_agent/app/robot/robot_command.h"
#include "nav_agent/app/ros/any_robot_file.h"
#include "nav_agent/app/route/route_command.h"
#include "nav_agent/app/run/run_command.h"
#include "nav_agent/app/score/score_command.h"
#include "nav_agent/app/simulate/simulate_command.h"
#include "nav_agent/app/suite/suite_command.h"
#include "nav_agent/app/traversability/traversability_command.h"
#include "nav_agent/app/zones/zones_command.h"

namespace treeline::agent_app {
namespace {

constexpr const char* kDescription =
    "Treeline's robot: maps, knows where it is, and drives. This program runs "
    "it, in the world or in a simulated one.";

std::vector<cli::Command> AddCommands(CLI::App& app) {
  return {simulate_app::AddSimulateCommand(app),
          map_app::AddMapCommand(app),
          run_app::AddRunCommand(app),
          navigate_app::AddNavigateCommand(app),
          route_app::AddRouteCommand(app),
          zones_app::AddZonesCommand(app),
          dock_app::AddDockCommand(app),
          doctor_app::AddDoctorCommand(app),
          plan_app::AddPlanCommand(app),
          localize_app::AddLocalizeCommand(app),
          traversability_app::AddTraversabilityCommand(app),
          score_app::AddScoreTrajectoryCommand(app),
          log_app::AddLogCommand(app),
          calibrate_app::AddCalibrateCommand(app),
          robot_app::AddRobotCommand(app),
          suite_app::AddSuiteCommand(app),
          bridge_app::AddBridgeCommand(app, ros_app::ReadSensorsOfFile)};
}

}  // namespace
}  // namespace treeline::agent_app

int main(int argc, char** argv) {
  constexpr int kUsage = 2;
  absl::StatusOr<std::vector<std::string>> words =
      treeline::bridge_app::WithoutRosArguments({argv, argv + argc});
  if (!words.ok()) {
    std::fprintf(stderr, "treeline-agent: %s\n",
                 std::string(words.status().message()).c_str());
    return kUsage;
  }
  std::vector<char*> arguments;
  for (std::string& word : *words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  return treeline::cli::RunProgram(
      {"treeline-agent", treeline::agent_app::kDescription},
      treeline::agent_app::AddCommands, static_cast<int>(words->size()),
      arguments.data());
}
