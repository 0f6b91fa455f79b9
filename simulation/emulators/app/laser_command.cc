#include "simulation/emulators/app/laser_command.h"

#include <cstdio>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "simulation/emulators/app/device_server.h"
#include "simulation/emulators/emulator_server.h"
#include "simulation/emulators/hokuyo_emulator.h"
#include "simulation/emulators/laser_source.h"

namespace treeline::emulator_app {
namespace {

constexpr const char* kDescription =
    "A Hokuyo UTM-30LX laser scanner in an empty room: it speaks SCIP 2.2 over "
    "a pseudo terminal or TCP, at 40 scans a second, and breaks when told to.";

constexpr const char* kFooter = R"(
Where to find it:
  pty                 a new pseudo terminal, whose name is printed
  pty:/tmp/ttyLaser   the same, with a symlink that leads to it
  tcp:10940           TCP, from this machine alone
  tcp:0.0.0.0:10940   TCP, from everywhere

Faults: KIND[:VALUE][@START[+DURATION]], times in seconds, as many as you like:
  corrupt:0.001       each byte is changed with this probability
  drop:0.001          each byte is lost with this probability
  split:7             bytes come in pieces of 1 to 7
  merge:0.05          bytes are kept back for 50 ms and then come at once
  garbage             noise instead of replies
  stuck               no reply at all
  unplug              the port or connection is gone
  error:52            reports this status: 21 to 49 it checks itself, 50 to 97
                      its hardware is broken
  skew:200            its clock runs 200 ppm fast

Examples:
  treeline-emulator laser --listen pty:/tmp/ttyLaser
      then, for ROS 1: rosrun urg_node urg_node _serial_port:=/tmp/ttyLaser
  treeline-emulator laser --listen tcp:10940 --room 12x4 --at 3,-1,90
      then: rosrun urg_node urg_node _ip_address:=127.0.0.1
      or by hand: `nc 127.0.0.1 10940`, and type VV, PP, MD0000108001001
  treeline-emulator laser --fault unplug@10+3 --fault corrupt:1e-4@20
      pulled out after ten seconds for three; a bad cable after twenty)";

struct LaserFlags {
  std::string listen = "pty";
  std::string model = "utm-30lx-ew";
  std::string room = "8x6";
  std::vector<double> at = {0, 0, 0};
  double noise_m = 0.01;
  double dropout = 0;
  std::vector<std::string> faults;
  uint64_t seed = 1;
  int64_t first_time_ms = 0;
};

absl::StatusOr<emulators::RoomOptions> RoomOf(const LaserFlags& flags) {
  TL_ASSIGN_OR_RETURN(emulators::RoomOptions room,
                      emulators::ParseRoom(flags.room));
  room.laser_x_m = flags.at[0];
  room.laser_y_m = flags.at[1];
  room.laser_yaw_rad = flags.at[2] * std::numbers::pi / 180;
  room.noise_m = flags.noise_m;
  room.dropout = flags.dropout;
  room.seed = flags.seed;
  TL_RETURN_IF_ERROR(room.Validate());
  return room;
}

emulators::HokuyoEmulatorOptions SensorOf(const LaserFlags& flags) {
  emulators::HokuyoEmulatorOptions sensor;
  sensor.first_time_ms = flags.first_time_ms;
  if (flags.model == "utm-30lx") {
    sensor.ethernet = false;
    sensor.parameters.model = "UTM-30LX(Hokuyo Automatic Co.,Ltd.)";
    sensor.version.product = "SOKUIKI Sensor TOP-URG UTM-30LX";
    sensor.version.protocol = "SCIP 2.0";
  }
  return sensor;
}

absl::Status Serve(const LaserFlags& flags, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const emulators::RoomOptions room, RoomOf(flags));
  TL_ASSIGN_OR_RETURN(emulators::EmulatorServerOptions options,
                      ServerOptionsOf(flags.listen, flags.faults, flags.seed));
  const emulators::HokuyoEmulatorOptions sensor = SensorOf(flags);
  TL_RETURN_IF_ERROR(sensor.Validate());
  const base::SteadyClock clock;
  emulators::RoomLaserSource source(room);
  emulators::HokuyoEmulator laser(sensor, source, clock.Now());
  TL_ASSIGN_OR_RETURN(const auto server, emulators::EmulatorServer::Start(
                                             std::move(options), laser, clock));
  std::printf("laser at %s\n", server->address().c_str());
  std::fflush(stdout);
  WaitForStop(stop);
  std::printf("stopped; received %lld bytes, sent %lld\n",
              static_cast<long long>(server->received()),
              static_cast<long long>(server->sent()));
  return absl::OkStatus();
}

}  // namespace

cli::Command AddLaserCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("laser", kDescription);
  command->footer(kFooter);
  // Held by the command that is returned.
  const auto flags = std::make_shared<LaserFlags>();
  command->add_option("--listen", flags->listen, "Where drivers find it")
      ->capture_default_str();
  command->add_option("--model", flags->model, "Which sensor it is")
      ->check(CLI::IsMember({"utm-30lx-ew", "utm-30lx"}))
      ->capture_default_str();
  command->add_option("--room", flags->room, "Width x depth of the room (m)")
      ->capture_default_str();
  command
      ->add_option("--at", flags->at,
                   "Where it stands, from the room's middle (m), and which way "
                   "it looks (degrees from x to y): X,Y,DEGREES")
      ->delimiter(',')
      ->expected(3)
      ->capture_default_str();
  command->add_option("--noise", flags->noise_m, "Of each range (m, 1 sigma)")
      ->capture_default_str();
  command
      ->add_option("--dropout", flags->dropout,
                   "How often a beam has no echo (0 to 1)")
      ->capture_default_str();
  command
      ->add_option("--fault", flags->faults,
                   "What goes wrong, and when; may be repeated")
      ->take_all();
  command->add_option("--seed", flags->seed, "Of noise and faults")
      ->capture_default_str();
  command
      ->add_option("--first-time-ms", flags->first_time_ms,
                   "What its clock says at first; it wraps at 16777216")
      ->capture_default_str();
  return {command,
          [flags](const std::stop_token& stop) { return Serve(*flags, stop); }};
}

}  // namespace treeline::emulator_app
