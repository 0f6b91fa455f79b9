#include "nav_agent/app/suite/docking_suite_command.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "common/base/status_macros.h"
#include "evaluation/dockings/docking_report.h"
#include "evaluation/dockings/docking_suite.h"
#include "evaluation/suites/suite_runner.h"
#include "nav_agent/app/suite/suite_flags.h"

namespace treeline::suite_app {
namespace {

constexpr const char* kFooter = R"(
Each world, scene and seed is one docking: the robot looks from its dock, is put
at least 3 m away, and drives back into it and out again. It is good if the
robot says that it is docked and stands, in truth, within 2 cm and 2 degrees of
where it stood before, has run into nothing and never took itself for lost.
docs/reference/suites.md describes scenes and the JSON file.

Examples:
  treeline-agent suite docking --seeds 1-25 --json docking.json
  treeline-agent suite docking --scenes moved,wide,niche --seeds 1-10
  treeline-agent suite docking --by-map --seeds 1-25)";

struct DockingFlags {
  suites::SuiteOptions suite = {
      .worlds = {"cafe", "lab", "two-storey", "seed:17"},
      .seeds = "1-10",
      .maps = "perfect",
      .folder = "out/suite/docking"};
  std::vector<std::string> scenes = {"plain"};
  bool by_map = false;
  bool contacts = false;
};

absl::Status RunDockings(const DockingFlags& flags,
                         const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const std::vector<uint64_t> seeds,
                      suites::ParseSeedList(flags.suite.seeds));
  suites::Suite<dockings::DockingRun> suite;
  suite.name = "dockings";
  suites::SuiteOptions with_people = flags.suite;
  for (const std::string& scene : flags.scenes) {
    with_people.people |= dockings::HasPeople(scene);
    for (suites::SuiteJob& job :
         suites::JobsOf(flags.suite.worlds, seeds, scene)) {
      suite.jobs.push_back(std::move(job));
    }
  }
  const auto map_options = [&with_people](const std::string& world) {
    return with_people.MapOptions(world);
  };
  TL_ASSIGN_OR_RETURN(
      const suites::SuitePlaces places,
      suites::PrepareSuite(suite.jobs, with_people, map_options, stop));
  const int expected = static_cast<int>(suite.jobs.size());
  suite.run = [&](const suites::SuiteJob& job,
                  const suites::SuitePlace& place) {
    dockings::DockingSuiteOptions options;
    options.seed = job.seed;
    options.scene = job.scene;
    options.by_sight = !flags.by_map;
    options.has_contacts = flags.contacts;
    options.has_rear_laser = !flags.suite.no_rear_laser;
    return dockings::RunDocking(place, options, stop);
  };
  suite.summary = [&](const std::vector<dockings::DockingRun>& runs) {
    return dockings::DockingSummary(runs, expected);
  };
  suite.json = [&](const std::vector<dockings::DockingRun>& runs) {
    return dockings::DockingJson(runs, expected);
  };
  suite.picture =
      [](const dockings::DockingRun& run) -> suites::RunPictureText {
    return {.stem = absl::StrCat(
                absl::StrReplaceAll(run.world, {{":", "-"}, {"/", "-"}}), "-",
                run.scene, "-", run.seed),
            .title = absl::StrCat(
                dockings::DockingSuiteOutcomeName(run.outcome), " ", run.why)};
  };
  return suites::RunSuite(suite, places, with_people, stop);
}

}  // namespace

cli::Command AddDockingSuite(CLI::App& suite) {
  CLI::App* command = suite.add_subcommand(
      "docking", "Drives into docks: who stands how exactly");
  command->footer(kFooter);
  auto flags = std::make_shared<DockingFlags>();
  AddSuiteFlags(*command, "docking", flags->suite);
  command
      ->add_option("--scenes", flags->scenes,
                   absl::StrCat("What kinds of docks, and what happens there: ",
                                absl::StrJoin(dockings::DockingScenes(), ", ")))
      ->type_name("SCENE,...")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::IsMember(dockings::DockingScenes()).description(""));
  command->add_flag("--by-map", flags->by_map,
                    "Go by the place on the map alone, not by what the laser "
                    "sees from a dock");
  command->add_flag("--people", flags->suite.people,
                    "People walk about; so they do if one of the scenes needs "
                    "them");
  command->add_flag("--contacts", flags->contacts,
                    "The battery tells of contacts, which reach 3 cm");
  return {command, [flags](const std::stop_token& stop) {
            return RunDockings(*flags, stop);
          }};
}

}  // namespace treeline::suite_app
