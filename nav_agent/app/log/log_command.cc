#include "nav_agent/app/log/log_command.h"

#include <cstdio>
#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "common/base/status_macros.h"
#include "nav_agent/ros_log/convert_log.h"

namespace treeline::log_app {
namespace {

constexpr const char* kFooter = R"(
Reads an agent log, a recording of ROS (.mcap, .db3, .bag, the folder of `ros2
bag record`) or a public laser log (CARMEN, JSON as of the Intel Research Lab,
Wean Hall's; also compressed). Writes MCAP with ROS 2's messages if OUTPUT ends
in .mcap, else an agent log. Foxglove, PlotJuggler and ROS 2 open the MCAP files.
Topics, and what does not fit: docs/reference/log.md.

Examples:
  treeline-agent log convert drive.tlog drive.mcap
  treeline-agent log convert drive.tlog drive.mcap --map house/level-0.yaml \
      --trajectory house/trajectory.txt
  treeline-agent log convert walk walk.tlog --scan-topic /front/scan
  treeline-agent log convert intel.clf.gz intel.mcap
  treeline-agent map --log walk.mcap --output house)";

struct LogFlags {
  std::string from;
  std::string to;
  std::string compression = "zstd";
  ros_log::ConvertOptions options;
};

absl::Status Convert(LogFlags& flags) {
  TL_ASSIGN_OR_RETURN(
      flags.options.compression,
      mcap::ParseCompression(flags.compression == "none" ? ""
                                                         : flags.compression));
  TL_ASSIGN_OR_RETURN(const ros_log::ConvertedLog converted,
                      ros_log::ConvertLog(flags.from, flags.to, flags.options));
  std::printf("%s (%s) -> %s: %lld entries", flags.from.c_str(),
              converted.from.c_str(), flags.to.c_str(),
              static_cast<long long>(converted.entries));
  if (converted.messages > 0) {
    std::printf(", %lld messages", static_cast<long long>(converted.messages));
  }
  std::printf("\n");
  for (const std::string& note : converted.notes) {
    std::printf("  note: %s\n", note.c_str());
  }
  return absl::OkStatus();
}

}  // namespace

cli::Command AddLogCommand(CLI::App& app) {
  CLI::App* group = app.add_subcommand("log",
                                       "Convert logs: agent log, MCAP, "
                                       "bags of ROS, CARMEN");
  group->require_subcommand(1);
  CLI::App* command =
      group->add_subcommand("convert", "Convert a log to MCAP or an agent log");
  command->footer(kFooter);
  auto flags = std::make_shared<LogFlags>();
  command->add_option("input", flags->from, "The log, of any kind")
      ->type_name("INPUT")
      ->required();
  command->add_option("output", flags->to, "What to write")
      ->type_name("OUTPUT")
      ->required();
  command
      ->add_option("--compression", flags->compression,
                   "Of the chunks of an MCAP file")
      ->type_name("zstd|lz4|none")
      ->capture_default_str();
  command
      ->add_option("--map", flags->options.map,
                   "Write this map into the MCAP file, too: map_server's YAML")
      ->type_name("FILE");
  command
      ->add_option("--trajectory", flags->options.trajectory,
                   "And this trajectory: 'time tx ty tz qx qy qz qw' (TUM)")
      ->type_name("FILE");
  ros_log::BagLogOptions& bag = flags->options.bag;
  constexpr const char* kRos = "Recordings of ROS";
  command
      ->add_option("--scan-topic", bag.scan_topic,
                   "Scans (default: /scan, or the most)")
      ->type_name("TOPIC")
      ->group(kRos);
  command
      ->add_option("--odometry-topic", bag.odometry_topic,
                   "Odometry (default: /odom, or the most)")
      ->type_name("TOPIC")
      ->group(kRos);
  command
      ->add_option("--color-topic", bag.color_topic,
                   "Colour pictures (default: as we write them, or none)")
      ->type_name("TOPIC")
      ->group(kRos);
  command
      ->add_option("--depth-topic", bag.depth_topic,
                   "Depth maps (default: as we write them, or none)")
      ->type_name("TOPIC")
      ->group(kRos);
  return {group,
          [flags](const std::stop_token& /*stop*/) { return Convert(*flags); }};
}

}  // namespace treeline::log_app
