#include "simulation/emulators/app/robot_command.h"

#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/drivers/stream/byte_stream.h"
#include "simulation/emulators/app/device_server.h"
#include "simulation/emulators/emulator_server.h"
#include "simulation/emulators/hokuyo_emulator.h"
#include "simulation/emulators/segway_device.h"
#include "simulation/emulators/simulated_robot.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/scenario_player.h"

namespace treeline::emulator_app {
namespace {

constexpr const char* kDescription =
    "A whole robot in a synthetic world: its Hokuyo UTM-30LX sees the world, "
    "its Segway RMP100 drives in it, both byte for byte as `laser` and `base` "
    "are; with --rear-laser a second one looks back. What happens to it is "
    "printed.";

constexpr const char* kFooter = R"(
Worlds: cafe, lab, office-floor, two-storey, seed:N, or a file of yours
(docs/reference/worlds.md). Where devices are found, and faults, are as for
`laser` and `base`; --laser-fault and --base-fault may be repeated.

Examples:
  treeline-emulator robot --world cafe \
      --laser pty:/tmp/ttyLaser --base pty:/tmp/ttyBase
  treeline-emulator robot --world lab --at 9.6,0.8,180 --laser tcp:10940 \
      --base pty:/tmp/ttyBase --base-fault unplug@30+5
  treeline-emulator robot --laser tcp:10940 --rear-laser tcp:10941)";

struct RobotFlags {
  std::string world = "cafe";
  std::vector<double> at;
  std::string laser = "pty";
  // Empty: there is none.
  std::string rear_laser;
  std::string base = "pty";
  std::vector<std::string> laser_faults;
  std::vector<std::string> base_faults;
  bool no_people = false;
  uint64_t seed = 1;
};

absl::StatusOr<std::unique_ptr<simulator::Simulator>> SimulatorOf(
    const RobotFlags& flags) {
  simulator::Scenario scenario;
  scenario.world = flags.world;
  scenario.world_options.with_people = !flags.no_people;
  if (!flags.at.empty()) {
    scenario.start = {.position = {flags.at[0], flags.at[1]},
                      .yaw_rad = flags.at[2] * std::numbers::pi / 180,
                      .height_m = flags.at.size() > 3 ? flags.at[3] : 0};
  }
  scenario.options.seed = flags.seed;
  // The emulated laser has its own clock, and scans when that says so.
  scenario.options.sensors.has_laser = false;
  TL_ASSIGN_OR_RETURN(worlds::World world, simulator::MakeWorldOf(scenario));
  return simulator::Simulator::Create(std::move(world), scenario.options);
}

void PrintEvents(simulator::Simulator& simulator) {
  for (const simulator::SimEvent& event : simulator.TakeEvents()) {
    std::printf(
        "%8.2f s  %s%s%s at %.2f, %.2f, %.2f\n", simulator::Seconds(event.time),
        simulator::SimEventName(event.kind), event.what.empty() ? "" : ": ",
        event.what.c_str(), event.point_in_world.x, event.point_in_world.y,
        event.point_in_world.z);
  }
  std::fflush(stdout);
}

absl::Status Serve(const RobotFlags& flags, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(
      emulators::EmulatorServerOptions laser_server,
      ServerOptionsOf(flags.laser, flags.laser_faults, flags.seed));
  TL_ASSIGN_OR_RETURN(
      emulators::EmulatorServerOptions base_server,
      ServerOptionsOf(flags.base, flags.base_faults, flags.seed));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<simulator::Simulator> simulator,
                      SimulatorOf(flags));
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<emulators::SimulatedRobot> robot,
                      emulators::SimulatedRobot::Create(*simulator, start));
  emulators::SegwayEmulatorOptions base_options;
  base_options.wheel_track_m = simulator->options().robot.wheel_track_m;
  base_options.seed = flags.seed;
  emulators::HokuyoEmulator laser(emulators::HokuyoEmulatorOptions(), *robot,
                                  start);
  emulators::SegwayDevice base(base_options, *robot, start);
  TL_ASSIGN_OR_RETURN(
      const auto laser_at,
      emulators::EmulatorServer::Start(std::move(laser_server), laser, clock));
  TL_ASSIGN_OR_RETURN(
      const auto base_at,
      emulators::EmulatorServer::Start(std::move(base_server), base, clock));
  emulators::HokuyoEmulator rear_laser(emulators::HokuyoEmulatorOptions(),
                                       robot->rear_laser(), start);
  std::unique_ptr<emulators::EmulatorServer> rear_laser_at;
  if (!flags.rear_laser.empty()) {
    TL_ASSIGN_OR_RETURN(
        emulators::EmulatorServerOptions rear_server,
        ServerOptionsOf(flags.rear_laser, flags.laser_faults, flags.seed + 1));
    TL_ASSIGN_OR_RETURN(rear_laser_at,
                        emulators::EmulatorServer::Start(std::move(rear_server),
                                                         rear_laser, clock));
  }
  std::printf("laser at %s\nbase at %s\n", laser_at->address().c_str(),
              base_at->address().c_str());
  if (rear_laser_at != nullptr) {
    std::printf("rear laser at %s\n", rear_laser_at->address().c_str());
  }
  std::fflush(stdout);
  while (!stream::StopRequestedWithin(std::chrono::milliseconds(200), stop)) {
    PrintEvents(*simulator);
  }
  const simulator::TrueState state = simulator->state();
  const geometry::Vec3& at = state.world_from_base.translation;
  std::printf("stopped at %.2f, %.2f, %.2f after %.2f m in %.1f s\n", at.x,
              at.y, at.z, state.distance_m, simulator::Seconds(state.time));
  return absl::OkStatus();
}

}  // namespace

cli::Command AddRobotCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("robot", kDescription);
  command->footer(kFooter);
  // Held by the command that is returned.
  const auto flags = std::make_shared<RobotFlags>();
  command->add_option("--world", flags->world, "Where it is")
      ->type_name("NAME|FILE|seed:N")
      ->capture_default_str();
  command
      ->add_option("--at", flags->at,
                   "Where it stands (m, degrees), and near which height; "
                   "default: where the world's tour begins")
      ->type_name("X,Y,DEGREES[,Z]")
      ->delimiter(',')
      ->expected(3, 4);
  command->add_option("--laser", flags->laser, "Where drivers find its laser")
      ->capture_default_str();
  command->add_option("--rear-laser", flags->rear_laser,
                      "Where drivers find a second one, that looks back; "
                      "default: there is none");
  command->add_option("--base", flags->base, "Where drivers find its base")
      ->capture_default_str();
  command
      ->add_option("--laser-fault", flags->laser_faults,
                   "What goes wrong with its lasers, and when")
      ->take_all();
  command
      ->add_option("--base-fault", flags->base_faults,
                   "What goes wrong with the base, and when")
      ->take_all();
  command->add_flag("--no-people", flags->no_people, "Nobody else is there");
  command->add_option("--seed", flags->seed, "Of noise, slip and faults")
      ->capture_default_str();
  return {command,
          [flags](const std::stop_token& stop) { return Serve(*flags, stop); }};
}

}  // namespace treeline::emulator_app
