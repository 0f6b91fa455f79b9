#include "simulation/emulators/app/base_command.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "simulation/emulators/app/device_server.h"
#include "simulation/emulators/emulator_server.h"
#include "simulation/emulators/segway_device.h"

namespace treeline::emulator_app {
namespace {

constexpr const char* kDescription =
    "A Segway RMP100 base on a level floor: 18-byte frames of its USB serial "
    "line over a pseudo terminal or TCP, a status cycle every 10 ms. It obeys "
    "motion commands, coasts to a stop 0.4 s after the last, and breaks when "
    "told to. What it has seen a driver do is printed at the end.";

constexpr const char* kFooter = R"(
Where to find it:
  pty                 a new pseudo terminal, whose name is printed
  pty:/tmp/ttySegway  the same, with a symlink that leads to it
  tcp:10941           TCP, from this machine alone
  tcp:0.0.0.0:10941   TCP, from everywhere

Faults: KIND[:VALUE][@START[+DURATION]], times in seconds, as many as you like:
  corrupt:0.001       each byte is changed with this probability
  drop:0.001          each byte is lost with this probability
  split:7             bytes come in pieces of 1 to 7
  merge:0.05          bytes are kept back for 50 ms and then come at once
  garbage             noise instead of frames
  stuck               it sends nothing at all
  unplug              the port or connection is gone
  error:1             what is broken, added up: 1 its motors are disabled,
                      2 its left wheel is stuck, 4 its right wheel is stuck

Sources disagree on three things about the real base; this one is as you say:
  --turn-scale, --turn-sign, --channel (docs/reference/base-driver.md)

Examples:
  treeline-emulator base --listen pty:/tmp/ttySegway
  treeline-emulator base --listen tcp:10941 --turn-sign=-1
  treeline-emulator base --fault unplug@10+3 --fault error:1@20+5)";

struct BaseFlags {
  std::string listen = "pty";
  std::string turn_scale = "degree";
  int turn_sign = 1;
  int yaw_rate_sign = 1;
  std::string channel = "aa";
  double track_m = 0.54;
  double battery_v = 72;
  std::vector<std::string> faults;
  uint64_t seed = 1;
};

emulators::SegwayEmulatorOptions BaseOf(const BaseFlags& flags) {
  emulators::SegwayEmulatorOptions base;
  base.wire.turn_scale = flags.turn_scale == "degree"
                             ? segway::SegwayWire::TurnScale::kPerDegree
                             : segway::SegwayWire::TurnScale::kPerHalfTurn;
  base.wire.turn_sign = flags.turn_sign;
  base.wire.yaw_rate_sign = flags.yaw_rate_sign;
  base.channel =
      flags.channel == "aa" ? segway::kSegwayChannelA : segway::kSegwayChannelB;
  base.wheel_track_m = flags.track_m;
  base.battery_v = flags.battery_v;
  base.seed = flags.seed;
  return base;
}

void PrintEnd(const emulators::SegwayEmulator& base) {
  const emulators::SegwayEmulatorCounts& counts = base.counts();
  std::printf(
      "stopped; wheels have rolled %.3f m (left) and %.3f m (right)\n"
      "commands %lld, of them less than 10 ms after another %lld, more than "
      "0.4 s %lld; settings %lld; broken %lld\n",
      base.state().left_wheel_m, base.state().right_wheel_m,
      static_cast<long long>(counts.commands),
      static_cast<long long>(counts.too_soon),
      static_cast<long long>(counts.too_late),
      static_cast<long long>(counts.settings),
      static_cast<long long>(counts.broken_commands));
}

absl::Status Serve(const BaseFlags& flags, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(emulators::EmulatorServerOptions options,
                      ServerOptionsOf(flags.listen, flags.faults, flags.seed));
  const emulators::SegwayEmulatorOptions base_options = BaseOf(flags);
  TL_RETURN_IF_ERROR(base_options.Validate());
  const base::SteadyClock clock;
  emulators::FlatFloorPlant floor(base_options.wheel_track_m);
  emulators::SegwayDevice base(base_options, floor, clock.Now());
  TL_ASSIGN_OR_RETURN(auto server, emulators::EmulatorServer::Start(
                                       std::move(options), base, clock));
  std::printf("base at %s\n", server->address().c_str());
  std::fflush(stdout);
  WaitForStop(stop);
  server.reset();
  PrintEnd(base.emulator());
  return absl::OkStatus();
}

}  // namespace

cli::Command AddBaseCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("base", kDescription);
  command->footer(kFooter);
  // Held by the command that is returned.
  const auto flags = std::make_shared<BaseFlags>();
  command->add_option("--listen", flags->listen, "Where drivers find it")
      ->capture_default_str();
  command
      ->add_option("--turn-scale", flags->turn_scale,
                   "Turn commands: 7.8 counts are 1 deg/s, or 1024 are pi "
                   "rad/s")
      ->check(CLI::IsMember({"degree", "half-turn"}))
      ->capture_default_str();
  command
      ->add_option("--turn-sign", flags->turn_sign,
                   "1: positive turn commands turn to the left")
      ->check(CLI::IsMember({1, -1}))
      ->capture_default_str();
  command
      ->add_option("--yaw-rate-sign", flags->yaw_rate_sign,
                   "1: a measured yaw rate to the left is positive")
      ->check(CLI::IsMember({1, -1}))
      ->capture_default_str();
  command
      ->add_option("--channel", flags->channel, "On which it sends its status")
      ->check(CLI::IsMember({"aa", "bb"}))
      ->capture_default_str();
  command->add_option("--track", flags->track_m, "Between its wheels (m)")
      ->capture_default_str();
  command->add_option("--battery", flags->battery_v, "When it is full (V)")
      ->capture_default_str();
  command
      ->add_option("--fault", flags->faults,
                   "What goes wrong, and when; may be repeated")
      ->take_all();
  command->add_option("--seed", flags->seed, "Of the faults")
      ->capture_default_str();
  return {command,
          [flags](const std::stop_token& stop) { return Serve(*flags, stop); }};
}

}  // namespace treeline::emulator_app
