#include "nav_agent/app/bridge/bridge_command.h"

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/strip.h"
#include "client/relocalizer/connect_options.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "common/config/config_flags.h"
#include "nav_agent/app/bridge/bridge_config.h"
#include "nav_agent/app/bridge/bridge_run.h"
#include "nav_agent/app/bridge/ros_parameters.h"
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

Every flag but --config and --params-file can stand in the file that --config
names, and in the environment, as TREELINE_BRIDGE_SERVER. Of the file of
--params-file (of ROS 2: NODE, ros__parameters, NAME: VALUE) those for this
node's name are read; they go before these and behind flags. What `ros2 launch`
writes behind --ros-args is understood.

Examples:
  treeline-agent bridge --server 127.0.0.1:50051 --scene house \
      --image camera/color/image_raw/compressed
  treeline-agent bridge --server reloc.local:50051 --namespace robot1 \
      --robot robot.yaml \
      --depth camera/aligned_depth_to_color/image_raw \
      --image camera/color/image_raw --map-from-world 1.2,-0.4,0,1.57
  treeline-agent bridge --ros-args --params-file robot.yaml -r __ns:=/robot1 \
      -p server:=127.0.0.1:50051)";

struct BridgeFlags {
  std::string config;
  std::vector<std::string> parameter_files;
  bool print_config = false;
  std::unique_ptr<config::ConfigFlags> settings;
  SensorsReader read_sensors;
};

// "/robot1/treeline", as far as all but parameter files say.
absl::StatusOr<std::string> FullNodeName(const config::ConfigSources& sources) {
  std::vector<config::Setting> settings = BridgeConfigTable().settings();
  for (config::Setting& setting : settings) setting.required = false;
  TL_ASSIGN_OR_RETURN(const config::EffectiveConfig effective,
                      config::ResolveConfig(settings, sources));
  const BridgeConfig config = BridgeConfigTable().Make(effective);
  TL_ASSIGN_OR_RETURN(
      const std::string below,
      dds::FullTopicName(
          "~/x", {.name_space = config.name_space, .node = config.node_name}));
  return std::string(absl::StripSuffix(below, "/x"));
}

// With what parameter files have, as if flags said it, where none does.
absl::StatusOr<RosParameters> AddParameters(
    const std::vector<std::string>& files, config::ConfigSources& sources) {
  RosParameters all;
  if (files.empty()) return all;
  TL_ASSIGN_OR_RETURN(const std::string node, FullNodeName(sources));
  for (const std::string& file : files) {
    TL_ASSIGN_OR_RETURN(
        RosParameters read,
        ReadRosParameters(file, node, BridgeConfigTable().settings()));
    for (auto& [name, parameter] : read.values) {
      if (sources.flags.contains(name)) continue;
      all.values[name] = std::move(parameter);
    }
    for (std::string& note : read.notes) all.notes.push_back(std::move(note));
  }
  for (const auto& [name, parameter] : all.values) {
    sources.flags[name] = parameter.text;
  }
  return all;
}

absl::Status Run(const BridgeFlags& flags, const std::stop_token& stop) {
  const config::ConfigTable<BridgeConfig>& table = BridgeConfigTable();
  config::ConfigSources sources = {
      .file = flags.config,
      .environment = config::EnvironmentWith(environ, kBridgePrefix),
      .environment_prefix = kBridgePrefix,
      .flags = flags.settings->Given()};
  TL_ASSIGN_OR_RETURN(const RosParameters parameters,
                      AddParameters(flags.parameter_files, sources));
  TL_ASSIGN_OR_RETURN(config::EffectiveConfig effective,
                      config::ResolveConfig(table.settings(), sources));
  for (const auto& [name, parameter] : parameters.values) {
    effective.at(name).origin = parameter.origin;
  }
  if (flags.print_config) {
    std::printf("%s", config::PrintConfig(table.settings(), effective).c_str());
    for (const std::string& note : parameters.notes) {
      std::fprintf(stderr, "note: %s\n", note.c_str());
    }
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
  for (const std::string& note : parameters.notes) {
    log->Say(logging::LogLevel::kWarn, note);
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
  command
      ->add_option("--params-file", flags->parameter_files,
                   "Parameter file of ROS 2; several: the last one counts")
      ->type_name("FILE")
      ->type_size(1)
      ->allow_extra_args(false);
  command->add_flag("--print-config", flags->print_config,
                    "Show what is in force, and where it comes from");
  flags->settings = std::make_unique<config::ConfigFlags>(
      *command, BridgeConfigTable().settings());
  return {command,
          [flags](const std::stop_token& stop) { return Run(*flags, stop); }};
}

}  // namespace treeline::bridge_app
