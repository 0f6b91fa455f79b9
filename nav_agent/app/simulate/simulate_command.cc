#include "nav_agent/app/simulate/simulate_command.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "simulation/runs/plan_picture.h"
#include "simulation/runs/simulation_run.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/scenario_reader.h"
#include "simulation/worlds/world_flags.h"

namespace treeline::simulate_app {
namespace {

constexpr const char* kFooter = R"(
Runs as fast as it can, which is much faster than real time.
docs/reference/simulator.md describes the robot, the scenario files, and what is
recorded as an event; docs/reference/agent-log.md the file that --record writes.

Examples:
  treeline-agent simulate --world cafe --drive tour --picture tour.png
  treeline-agent simulate --scenario kidnap.yaml --json kidnap.json
  treeline-agent simulate --world seed:7 --drive tour --camera-hz 10 \
      --record drive.tlog)";

struct SimulateFlags {
  std::string world;
  std::string scenario;
  std::string drive = "none";
  double speed_mps = 0.5;
  double look_every_m = 2.0;
  double seconds = 0;
  uint64_t seed = 0;
  bool has_seed = false;
  bool no_laser = false;
  bool no_people = false;
  std::optional<building::Lighting> lighting;
  worlds::Rearrangement rearranged;
  double camera_hz = -1;
  int threads = 0;
  std::string record;
  std::string json;
  std::string picture;
  bool quiet = false;
};

absl::StatusOr<runs::SimulationRunOptions> OptionsOf(
    const SimulateFlags& flags) {
  runs::SimulationRunOptions run;
  if (!flags.scenario.empty()) {
    TL_ASSIGN_OR_RETURN(run.scenario, simulator::ReadScenario(flags.scenario));
  }
  simulator::Scenario& scenario = run.scenario;
  if (!flags.world.empty()) scenario.world = flags.world;
  if (flags.has_seed) scenario.options.seed = flags.seed;
  if (flags.seconds > 0)
    scenario.duration = simulator::FromSeconds(flags.seconds);
  if (flags.no_laser) scenario.options.sensors.has_laser = false;
  if (flags.no_people) scenario.world_options.with_people = false;
  if (flags.lighting.has_value()) {
    scenario.world_options.lighting = flags.lighting;
  }
  if (flags.rearranged.share > 0) {
    scenario.world_options.rearranged = flags.rearranged;
  }
  if (flags.camera_hz >= 0) {
    scenario.options.sensors.camera_hz = flags.camera_hz;
  }
  scenario.options.threads = flags.threads;
  scenario.world_options.threads = flags.threads;
  if (flags.drive != "none") {
    simulator::TourAction tour;
    tour.options.speed_mps = flags.speed_mps;
    if (flags.drive == "survey") {
      tour.options.look_around_every_m = flags.look_every_m;
    }
    tour.options.repeats = scenario.duration > simulator::SimTime(0);
    TL_RETURN_IF_ERROR(tour.options.Validate());
    run.tour = tour;
  }
  if (scenario.duration == simulator::SimTime(0) && !run.tour.has_value()) {
    return absl::InvalidArgumentError(
        "how long? Give --seconds, --drive tour, or a scenario with "
        "duration_s");
  }
  run.record_path = flags.record;
  for (const std::string* path : {&flags.record, &flags.json, &flags.picture}) {
    if (!path->empty()) TL_RETURN_IF_ERROR(base::CheckWritable(*path));
  }
  return run;
}

absl::StatusOr<runs::SimulationResult> RunWithProgress(
    simulator::Simulator& simulator, const runs::SimulationRunOptions& run,
    bool quiet, const std::stop_token& stop) {
  // A drive without an end takes about as long as its tour.
  double expected_s = simulator::Seconds(run.scenario.duration);
  if (expected_s <= 0) {
    const auto& tour = simulator.world().tour;
    for (size_t i = 0; i < tour.size(); ++i) {
      expected_s += Norm(tour[(i + 1) % tour.size()] - tour[i]) /
                    run.tour->options.speed_mps;
    }
  }
  const auto total = static_cast<int64_t>(expected_s) + 1;
  base::Progress progress("simulating", total, quiet);
  int64_t shown = 0;
  return runs::RunSimulation(
      simulator, run,
      [&](double simulated_s) {
        const auto now = std::min(static_cast<int64_t>(simulated_s), total);
        if (now > shown) progress.Add(now - shown);
        shown = now;
      },
      stop);
}

absl::Status Simulate(const SimulateFlags& flags, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(runs::SimulationRunOptions run, OptionsOf(flags));
  simulator::Scenario& scenario = run.scenario;
  // Pictures are painted only for a camera.
  scenario.world_options.paint = scenario.options.sensors.camera_hz > 0;
  TL_ASSIGN_OR_RETURN(worlds::World world, simulator::MakeWorldOf(scenario));
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<simulator::Simulator> simulator,
      simulator::Simulator::Create(std::move(world), scenario.options));
  TL_ASSIGN_OR_RETURN(const runs::SimulationResult result,
                      RunWithProgress(*simulator, run, flags.quiet, stop));
  std::printf("%s", runs::SimulationSummary(result).c_str());
  if (!flags.record.empty()) {
    std::printf("Recorded in %s\n", flags.record.c_str());
  }
  if (!flags.json.empty()) {
    TL_RETURN_IF_ERROR(
        base::WriteFileAtomically(flags.json, runs::SimulationJson(result)));
  }
  if (flags.picture.empty()) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::string png,
                      image::EncodePng(runs::DrawPlan(
                          simulator->world(), simulator->terrain(), result)));
  return base::WriteFileAtomically(flags.picture, png);
}

}  // namespace

cli::Command AddSimulateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "simulate", "Drive a simulated robot through a synthetic world");
  command->footer(kFooter);
  auto flags = std::make_shared<SimulateFlags>();
  command
      ->add_option("--world", flags->world,
                   "The world; otherwise the scenario's, or cafe")
      ->type_name("NAME|FILE|seed:N");
  command
      ->add_option("--scenario", flags->scenario,
                   "What happens, when; other options override it")
      ->type_name("FILE");
  command
      ->add_option("--drive", flags->drive,
                   "tour: along the world's tour; to its end, or round and "
                   "round for --seconds. survey: the same, and the robot looks "
                   "around on its way, for a map that a forest learns from")
      ->check(CLI::IsMember({"none", "tour", "survey"}))
      ->capture_default_str();
  command->add_option("--speed", flags->speed_mps, "Of the tour, in m/s")
      ->type_name("M/S")
      ->capture_default_str();
  command
      ->add_option("--look-every", flags->look_every_m,
                   "A survey's way from one look around to the next")
      ->type_name("M")
      ->check(CLI::Range(0.2, 100.0))
      ->capture_default_str();
  command->add_option("--seconds", flags->seconds, "How long, simulated")
      ->type_name("N");
  CLI::Option* seed =
      command
          ->add_option("--seed", flags->seed,
                       "Another seed is other noise and other slip in the same "
                       "world")
          ->type_name("N");
  command->add_flag("--no-laser", flags->no_laser, "Without the laser scanner");
  command->add_flag("--no-people", flags->no_people, "Nobody is about");
  worlds::AddLightFlag(*command, "--light",
                       "Light of the world, for the camera; otherwise that of "
                       "the scenario or the world's file, or day",
                       flags->lighting);
  worlds::AddRearrangedFlag(*command, flags->rearranged);
  command
      ->add_option("--camera-hz", flags->camera_hz,
                   "RGB-D frames in a second; 0: none")
      ->type_name("HZ");
  command
      ->add_option("--threads", flags->threads,
                   "For pictures; 0: one a processor")
      ->type_name("N");
  command->add_option("--record", flags->record, "Write an agent log")
      ->type_name("FILE");
  command->add_option("--json", flags->json, "Write the result as JSON")
      ->type_name("FILE");
  command
      ->add_option("--picture", flags->picture,
                   "Write a plan with the way that was taken")
      ->type_name("FILE.png");
  command->add_flag("--quiet", flags->quiet, "Show no progress");
  return {command, [flags, seed](const std::stop_token& stop) {
            flags->has_seed = seed->count() > 0;
            return Simulate(*flags, stop);
          }};
}

}  // namespace treeline::simulate_app
