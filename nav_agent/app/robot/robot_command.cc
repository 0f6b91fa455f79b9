#include "nav_agent/app/robot/robot_command.h"

#include <cstdio>
#include <memory>
#include <string>

#include "CLI/CLI.hpp"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "nav_agent/urdf/urdf_robot.h"

namespace treeline::robot_app {
namespace {

constexpr const char* kFooter = R"(
Reads a URDF: footprint (the hull of the collision shapes, seen from above),
height, wheels, and where lasers and camera are. Speeds and how the laser scans
are those of the robot --like. The result is a robot's file
(docs/reference/robots.md). xacro is not expanded; do that first.

Examples:
  xacro jackal.urdf.xacro > jackal.urdf
  treeline-agent robot from-urdf jackal.urdf --laser-link front_laser \
      --like jackal > robot.yaml
  treeline-agent run --simulate lab --robot ./robot.yaml)";

struct RobotFlags {
  std::string file;
  std::string output;
  urdf::UrdfRobotOptions options;
};

absl::Status FromUrdf(const RobotFlags& flags) {
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(flags.file, urdf::kMaxUrdfBytes));
  TL_ASSIGN_OR_RETURN(const urdf::Urdf urdf, urdf::ParseUrdf(text, flags.file));
  const auto robot = urdf::RobotOfUrdf(urdf, flags.options);
  if (!robot.ok()) return base::Annotate(robot.status(), flags.file);
  for (const std::string& note : robot->notes) {
    std::fprintf(stderr, "note: %s\n", note.c_str());
  }
  if (!flags.output.empty()) {
    return base::WriteFileAtomically(flags.output, robot->yaml);
  }
  std::printf("%s", robot->yaml.c_str());
  return absl::OkStatus();
}

}  // namespace

cli::Command AddRobotCommand(CLI::App& app) {
  CLI::App* group =
      app.add_subcommand("robot", "Make files that describe robots");
  group->require_subcommand(1);
  CLI::App* command =
      group->add_subcommand("from-urdf", "Make a robot's file of a URDF");
  command->footer(kFooter);
  auto flags = std::make_shared<RobotFlags>();
  urdf::UrdfRobotOptions& options = flags->options;
  command->add_option("file", flags->file, "The URDF")
      ->type_name("URDF")
      ->required();
  command
      ->add_option("--laser-link", options.laser_link,
                   "The laser (default: the link whose name says so)")
      ->type_name("LINK");
  command
      ->add_option("--rear-laser-link", options.rear_laser_link,
                   "A laser that looks back (default: there is none)")
      ->type_name("LINK");
  command
      ->add_option("--camera-link", options.camera_link,
                   "The camera; '...optical...' has z ahead, others x "
                   "(default: the only optical one)")
      ->type_name("LINK");
  command
      ->add_option("--base-link", options.base_link,
                   "Below the middle of the axle (default: base_footprint, "
                   "base_link, or the root)")
      ->type_name("LINK");
  command
      ->add_option("--like", options.like,
                   "The robot that has what the URDF does not say")
      ->type_name("NAME")
      ->capture_default_str();
  command
      ->add_option("--output", flags->output,
                   "Where the robot's file goes (default: standard output)")
      ->type_name("FILE");
  return {command, [flags](const std::stop_token& /*stop*/) {
            return FromUrdf(*flags);
          }};
}

}  // namespace treeline::robot_app
