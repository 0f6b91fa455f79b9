#include "nav_agent/app/bridge/bridge_command.h"

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "client/relocalizer/connect_options.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "common/config/config_flags.h"
#include "nav_agent/app/bridge/bridge_config.h"
#include "nav_agent/app/bridge/bridge_run.h"
#include "nav_agent/app/relocalization/server_relocalization.h"

namespace treeline::bridge_app {
namespace {

constexpr const char* kFooter = R"(
Speaks the DDS of ROS 2 without one being installed. It asks a treeline-server
where the robot is when nobody knows yet (no transform from map to odom), when
scans do not fit where the robot is thought to be, and when something is
published on ~/relocalize (std_msgs/Empty). What the gate lets pass goes to
/initialpose, which Nav2's AMCL, slam_toolbox and RTAB-Map take; how things are
goes to /diagnostics. docs/how-to/ros2.md tells the rest.

Every flag but --config can stand in the file that --config names, and in the
environment, as TREELINE_BRIDGE_SERVER.

Examples:
  treeline-agent bridge --server 127.0.0.1:50051 --scene house \
      --image camera/color/image_raw/compressed
  treeline-agent bridge --server reloc.local:50051 --namespace robot1 \
      --robot robot.yaml \
      --depth camera/aligned_depth_to_color/image_raw \
      --image camera/color/image_raw --map-from-world 1.2,-0.4,0,1.57)";

struct BridgeFlags {
  std::string config;
  bool print_config = false;
  std::unique_ptr<config::ConfigFlags> settings;
  SensorsReader read_sensors;
};

absl::Status Run(const BridgeFlags& flags, const std::stop_token& stop) {
  const config::ConfigTable<BridgeConfig>& table = BridgeConfigTable();
  const config::ConfigSources sources = {
      .file = flags.config,
      .environment = config::EnvironmentWith(environ, kBridgePrefix),
      .environment_prefix = kBridgePrefix,
      .flags = flags.settings->Given()};
  TL_ASSIGN_OR_RETURN(const config::EffectiveConfig effective,
                      config::ResolveConfig(table.settings(), sources));
  if (flags.print_config) {
    std::printf("%s", config::PrintConfig(table.settings(), effective).c_str());
    return absl::OkStatus();
  }
  const BridgeConfig config = table.Make(effective);
  const auto log = logging::LogToStandardError(
      "treeline-agent", logging::LogFormatOf(config.log_format));
  log->SetLevel(logging::LogLevelOf(config.log_level));
  log->TakeGrpcMessages();
  for (const std::string& variable :
       config::UnknownVariables(table.settings(), sources)) {
    log->Say(logging::LogLevel::kWarn,
             "environment: no setting belongs to " + variable);
  }
  TL_RETURN_IF_ERROR(config.Validate());
  SensorsOfFile sensors;
  if (!config.robot.empty()) {
    TL_ASSIGN_OR_RETURN(sensors, flags.read_sensors(config.robot));
    if (!sensors.base_from_camera.has_value()) {
      log->Say(logging::LogLevel::kWarn,
               config.robot +
                   " does not say where the camera is: that is as "
                   "/tf_static has it");
    }
  }
  relocalizer::ConnectOptions connect;
  connect.server = config.server;
  connect.tls.ca_file = config.tls_ca;
  connect.token_file = config.token_file;
  const base::SteadyClock clock;
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<core::RelocalizationPort> server,
      relocalization::MakeServerRelocalization(connect, config.scene, clock));
  return RunBridge(
      config, sensors, *server, *log,
      [](const std::string& line) {
        std::printf("%s\n", line.c_str());
        std::fflush(stdout);
      },
      stop);
}

}  // namespace

cli::Command AddBridgeCommand(CLI::App& app, SensorsReader read_sensors) {
  CLI::App* command =
      app.add_subcommand("bridge", "Tell a robot that runs ROS 2 where it is");
  command->footer(kFooter);
  auto flags = std::make_shared<BridgeFlags>();
  flags->read_sensors = std::move(read_sensors);
  command
      ->add_option("--config", flags->config, "Settings below those of flags")
      ->type_name("FILE");
  command->add_flag("--print-config", flags->print_config,
                    "Show what is in force, and where it comes from");
  flags->settings = std::make_unique<config::ConfigFlags>(
      *command, BridgeConfigTable().settings());
  return {command,
          [flags](const std::stop_token& stop) { return Run(*flags, stop); }};
}

}  // namespace treeline::bridge_app
