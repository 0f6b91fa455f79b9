#include "nav_agent/app/suite/kidnap_suite_command.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/relocalizer/grpc_relocalizer.h"
#include "client/relocalizer/relocalizer.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "evaluation/kidnaps/kidnap_report.h"
#include "evaluation/kidnaps/kidnap_server.h"
#include "evaluation/kidnaps/kidnap_suite.h"
#include "evaluation/suites/suite_runner.h"
#include "nav_agent/app/suite/suite_flags.h"
#include "simulation/worlds/world_flags.h"

namespace treeline::suite_app {
namespace {

constexpr const char* kFooter = R"(
Each world and seed is one kidnap. Of odd seeds it is warm: a robot that drives
to a goal is carried to another place. Of even ones it is cold: the robot is
told a wrong place as it begins. Good is who drives to the goal again within 20
simulated seconds, knows where it is to 0.5 m and 20 degrees, and has touched
nothing. Who goes on with a wrong pose is counted apart. See
docs/reference/suites.md.

Each world is mapped by a simulated drive, and its scene's forest is trained by
the program `treeline`, once: minutes, kept in --cache. --spawn-server starts
`treeline-server` on them as a process of its own; --server HOST:PORT asks one
that runs (of CACHE/models).

Examples:
  treeline-agent suite kidnaps --spawn-server --seeds 1-20 --json kidnaps.json
  treeline-agent suite kidnaps --worlds cafe --spawn-server \
      --server-fault killed
  treeline-agent suite kidnaps --spawn-server --light evening \
      --rearranged 1:0.3
  treeline-agent suite kidnaps --worlds cafe --method amcl)";

struct KidnapFlags {
  suites::SuiteOptions suite = {
      .worlds = {"cafe", "lab", "office-floor", "two-storey", "seed:17"},
      .seeds = "1-20",
      .maps = "driven",
      .folder = "out/suite/kidnaps"};
  std::string server;
  bool spawns_server = false;
  std::string fault = "none";
  std::string method = "server";
  double camera_hz = 5;
  std::optional<building::Lighting> lighting;
  std::optional<building::Lighting> map_lighting;
  std::string until = "goal";
};

// What answers, if anything does.
struct Asked {
  std::unique_ptr<kidnaps::KidnapServer> process;
  std::shared_ptr<relocalizer::Relocalizer> connection;
};

absl::StatusOr<behavior::RelocalizationMethod> MethodOf(
    const KidnapFlags& flags) {
  if (flags.method == "amcl") return behavior::RelocalizationMethod::kAmclOnly;
  if (flags.method == "injection")
    return behavior::RelocalizationMethod::kInjectionOnly;
  if (flags.server.empty() && !flags.spawns_server) {
    return absl::InvalidArgumentError(
        "whom shall lost robots ask? Give --spawn-server, or --server "
        "HOST:PORT, or --method amcl");
  }
  if (!flags.server.empty() && flags.fault != "none") {
    return absl::InvalidArgumentError(
        "--server-fault breaks a server of the suite's own: it needs "
        "--spawn-server");
  }
  return behavior::RelocalizationMethod::kServer;
}

suites::SuiteMapOptions MapOptionsOf(const KidnapFlags& flags,
                                     const std::string& world) {
  suites::SuiteMapOptions options = flags.suite.MapOptions(world);
  options.paint = flags.method == "server";
  options.lighting = flags.lighting.value_or(building::Lighting::kDay);
  options.map_lighting = flags.map_lighting.value_or(building::Lighting::kDay);
  return options;
}

absl::StatusOr<Asked> StartServer(const KidnapFlags& flags,
                                  const std::stop_token& stop) {
  Asked asked;
  if (flags.method != "server") return asked;
  TL_ASSIGN_OR_RETURN(const kidnaps::ServerFault fault,
                      kidnaps::ParseServerFault(flags.fault));
  std::string address = flags.server;
  if (flags.spawns_server) {
    std::string models;
    std::vector<std::string> scenes;
    // A server that never answers needs to know nothing.
    const bool answers = fault != kidnaps::ServerFault::kKilled &&
                         fault != kidnaps::ServerFault::kSlow;
    if (!answers) {
      models = flags.suite.cache + "/no-models";
      TL_RETURN_IF_ERROR(base::MakeParentFolder(models + "/none"));
    }
    for (const std::string& world : flags.suite.worlds) {
      if (!answers) break;
      const suites::SuiteMapOptions map = MapOptionsOf(flags, world);
      TL_ASSIGN_OR_RETURN(models, suites::ModelsForSuite(map, stop));
      scenes.push_back(suites::SuiteSceneName(map));
    }
    if (fault == kidnaps::ServerFault::kWrongScene) {
      const std::string wrong = flags.suite.cache + "/wrong-models";
      TL_RETURN_IF_ERROR(kidnaps::MakeWrongModels(models, scenes, wrong));
      models = wrong;
    }
    TL_ASSIGN_OR_RETURN(asked.process,
                        kidnaps::KidnapServer::Spawn(
                            models, flags.suite.cache + "/server.log", stop));
    address = asked.process->address();
    asked.process->Break(fault);
  }
  relocalizer::ConnectOptions connect;
  connect.server = address;
  // Of 640x480 pixels, compressed without loss.
  connect.max_message_mib = 64;
  if (fault == kidnaps::ServerFault::kKilled) connect.max_attempts = 1;
  TL_ASSIGN_OR_RETURN(asked.connection,
                      relocalizer::ConnectRelocalizer(connect));
  return asked;
}

suites::RunPictureText PictureText(const kidnaps::KidnapRun& run,
                                   const KidnapFlags& flags) {
  return {.stem = absl::StrCat(suites::SuiteWorldName(run.world), "-",
                               flags.method, "-", flags.fault, "-", run.seed),
          .title = absl::StrFormat(
              "%s (%s) %s; kidnapped after %.2f s (%s), noticed after %.2f s "
              "more, back after %.2f s; error when it went on %.2f m, %.0f deg",
              kidnaps::KidnapOutcomeName(run.outcome),
              core::NavigationCauseName(run.cause), run.why, run.kidnap_s,
              run.is_warm ? "warm" : "cold", run.noticed_after_s,
              run.back_after_s, run.error_at_resumption.distance_m,
              run.error_at_resumption.turn_deg)};
}

absl::Status RunKidnaps(const KidnapFlags& flags, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const std::vector<uint64_t> seeds,
                      suites::ParseSeedList(flags.suite.seeds));
  kidnaps::KidnapOptions options;
  TL_ASSIGN_OR_RETURN(options.navigator.lost.method, MethodOf(flags));
  TL_ASSIGN_OR_RETURN(options.robot, core::ReadRobot(flags.suite.robot));
  options.drives_on = flags.until == "goal";
  options.has_rear_laser = !flags.suite.no_rear_laser;
  options.camera_hz = flags.method == "server" ? flags.camera_hz : 0;
  if (flags.fault == "slow") options.real_timeout_s = 1;
  // Nobody looks at pictures that nobody answers.
  options.sees_depth = flags.fault == "killed" || flags.fault == "slow";
  suites::Suite<kidnaps::KidnapRun> suite;
  suite.name = "kidnaps";
  suite.jobs = suites::JobsOf(flags.suite.worlds, seeds);
  TL_ASSIGN_OR_RETURN(
      const suites::SuitePlaces places,
      suites::PrepareSuite(
          suite.jobs, flags.suite,
          [&](const std::string& world) {
            suites::SuiteMapOptions map = MapOptionsOf(flags, world);
            map.robot_radius_m = suites::PlaceRadius_m(options.robot->model);
            return map;
          },
          stop));
  TL_ASSIGN_OR_RETURN(const Asked asked, StartServer(flags, stop));
  options.server = asked.connection;
  const int expected = static_cast<int>(suite.jobs.size());
  suite.run = [&](const suites::SuiteJob& job,
                  const suites::SuitePlace& place) {
    kidnaps::KidnapOptions kidnap = options;
    kidnap.seed = job.seed;
    kidnap.scene = suites::SuiteSceneName(MapOptionsOf(flags, job.world));
    return kidnaps::RunKidnap(place, kidnap, stop);
  };
  suite.summary = [&](const std::vector<kidnaps::KidnapRun>& runs) {
    return kidnaps::KidnapSummary(runs, expected);
  };
  suite.json = [&](const std::vector<kidnaps::KidnapRun>& runs) {
    const suites::SuiteMapOptions map = MapOptionsOf(flags, "");
    return kidnaps::KidnapJson(runs, expected,
                               {.method = flags.method,
                                .fault = flags.fault,
                                .lighting = map.lighting,
                                .map_lighting = map.map_lighting,
                                .rearranged = map.rearranged});
  };
  suite.picture = [&](const kidnaps::KidnapRun& run) {
    return PictureText(run, flags);
  };
  return suites::RunSuite(suite, places, flags.suite, stop);
}

void AddServerFlags(CLI::App& command, KidnapFlags& flags) {
  CLI::Option* server =
      command.add_option("--server", flags.server, "Who is asked")
          ->type_name("HOST:PORT");
  command
      .add_flag("--spawn-server", flags.spawns_server,
                "Start a server on the suite's own models")
      ->excludes(server);
  command
      .add_option("--server-fault", flags.fault,
                  "killed: it is dead; slow: it takes connections and does not "
                  "answer; wrong-scene: it has another world's model under the "
                  "scene's name")
      ->check(CLI::IsMember({"none", "killed", "slow", "wrong-scene"}))
      ->capture_default_str();
  command
      .add_option("--method", flags.method,
                  "server; for comparison amcl (looks everywhere with the "
                  "laser alone) and injection (only AMCL's random particles)")
      ->check(CLI::IsMember({"server", "amcl", "injection"}))
      ->capture_default_str();
}

}  // namespace

cli::Command AddKidnapSuite(CLI::App& suite) {
  CLI::App* command = suite.add_subcommand(
      "kidnaps", "Robots that are kidnapped: how many recover");
  command->footer(kFooter);
  auto flags = std::make_shared<KidnapFlags>();
  AddSuiteFlags(*command, "kidnap", flags->suite);
  AddRobotFlag(*command, flags->suite);
  command->add_flag("--people", flags->suite.people, "People walk about");
  worlds::AddLightFlag(*command, "--light",
                       "Light that robots are kidnapped in; otherwise day",
                       flags->lighting);
  worlds::AddLightFlag(*command, "--map-light",
                       "Light that the worlds were mapped and learnt in; "
                       "otherwise day",
                       flags->map_lighting);
  AddServerFlags(*command, *flags);
  command->add_option("--camera-hz", flags->camera_hz, "Of a robot that looks")
      ->type_name("HZ")
      ->check(CLI::Range(0.5, 30.0))
      ->capture_default_str();
  command
      ->add_option("--until", flags->until,
                   "goal: drives on to its goal; back: a run ends when the "
                   "robot is back on its way, which is quicker")
      ->check(CLI::IsMember({"goal", "back"}))
      ->capture_default_str();
  return {command, [flags](const std::stop_token& stop) {
            return RunKidnaps(*flags, stop);
          }};
}

}  // namespace treeline::suite_app
