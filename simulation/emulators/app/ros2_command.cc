#include "simulation/emulators/app/ros2_command.h"

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "CLI/CLI.hpp"
#include "common/base/status_macros.h"
#include "nav_agent/bridge/dds/domain.h"
#include "simulation/ros2_robot/ros2_robot.h"

namespace treeline::emulator_app {
namespace {

constexpr const char* kDescription =
    "A robot that speaks ROS 2, in a synthetic world: publishes scan, odom, "
    "/tf_static, /clock and, with --camera-hz, pictures, and drives as cmd_vel "
    "says. No ROS is needed.";

constexpr const char* kFooter = R"(
It takes orders, a line each, from standard input (m, rad, in the world):

  tour                  somebody drives the world's tour, by remote control
  kidnap X Y YAW        the robot is elsewhere
  place X Y YAW         somebody clicks "2D Pose Estimate" (initialpose)
  goal X Y YAW          somebody clicks "2D Goal Pose" (goal_pose)
  silence TOPIC SECONDS scan, odom or clock says nothing for so long
  jump SECONDS          the clock that stamps are of is set ahead by so much
  nonsense              scans and odometry that are none

Twice a second a line says where it is (true=X,Y,YAW in the world), whether the
tour goes on (tour=1), what cmd_vel says, and what it hears: how far amcl_pose
(place_off=m,rad) and /tf (tf_off) are from the truth, and [diagnostics].

Examples:
  treeline-emulator ros2 --world cafe --interface lo
  mkfifo orders
  treeline-emulator ros2 --world flat.yaml <> orders > robot.log &
  echo tour > orders)";

absl::Status Play(ros2_robot::Ros2RobotOptions options, int domain_id,
                  const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(options.domain.id,
                      dds::DomainId(domain_id, std::getenv("ROS_DOMAIN_ID")));
  std::fprintf(stderr, "a robot in domain %d\n", options.domain.id);
  return ros2_robot::PlayRos2Robot(options, stop);
}

}  // namespace

cli::Command AddRos2Command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("ros2", kDescription);
  command->footer(kFooter);
  // Held by the command that is returned.
  const auto flags = std::make_shared<ros2_robot::Ros2RobotOptions>();
  const auto domain_id = std::make_shared<int>(-1);
  command->add_option("--world", flags->world, "Where it is")
      ->type_name("NAME|FILE|seed:N")
      ->capture_default_str();
  command
      ->add_option("--domain-id", *domain_id,
                   "DDS domain; -1: ROS_DOMAIN_ID of the environment, or 0")
      ->capture_default_str();
  command
      ->add_option("--interface", flags->domain.interface,
                   "Network interface to use alone, without multicast if 'lo'")
      ->type_name("NAME");
  command
      ->add_option("--namespace", flags->node.name_space,
                   "Of its topics but /tf, /tf_static, /clock, /diagnostics")
      ->type_name("NAME");
  command
      ->add_option("--pace", flags->pace,
                   "Simulated seconds in a real one, told on /clock; 0: real "
                   "time, without /clock")
      ->capture_default_str();
  command
      ->add_option("--camera-hz", flags->camera_hz,
                   "Pictures a second (camera/image_raw/compressed); 0: none")
      ->capture_default_str();
  command->add_flag("--plain", flags->is_plain,
                    "One laser of 541 beams at 20 Hz, as small robots have; "
                    "else two, of which the first has 1081 at 40 Hz");
  command->add_flag("--people", flags->has_people, "Others walk about, too");
  command->add_option("--seed", flags->seed, "Of noise and slip")
      ->capture_default_str();
  return {command, [flags, domain_id](const std::stop_token& stop) {
            return Play(*flags, *domain_id, stop);
          }};
}

}  // namespace treeline::emulator_app
