#include "nav_agent/app/suite/mission_suite_command.h"

#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "evaluation/missions/mission_suite.h"
#include "evaluation/missions/suite_report.h"
#include "evaluation/suites/suite_jobs.h"
#include "evaluation/suites/suite_maps.h"
#include "nav_agent/app/suite/suite_flags.h"

namespace treeline::suite_app {
namespace {

constexpr const char* kFooter = R"(
Each world and seed is one mission: the robot is told where it is, and drives
from there to a place at least 4 m away. A mission is good if it says that it
has arrived, stands within 0.5 m and 20 degrees of the goal, and has neither run
into anything, nor got onto stairs, nor fallen. docs/reference/suites.md
describes the missions and the JSON file.

Failed missions are data: the exit code is 0 if all were run. With --require
0.99 it is 1 if fewer than that share were good. Interrupted, the suite writes
what it has.

Examples:
  treeline-agent suite missions --seeds 1-50 --json missions.json
  treeline-agent suite missions --worlds cafe,seed:17 --people --seeds 1-20
  treeline-agent suite missions --scenes slope,blocked,person --seeds 1-10
  treeline-agent suite missions --worlds lab --seeds 1004 --pictures all)";

// Carts have decks below the laser's plane.
constexpr double kPeopleCamera_hz = 5;

struct MissionFlags {
  SuiteFlags suite = {.worlds = {"cafe", "lab", "two-storey", "seed:17"},
                      .seeds = "1-50",
                      .maps = "perfect",
                      .folder = "out/suite/missions"};
  std::vector<std::string> scenes;
  std::string planner;
  // Negative: kPeopleCamera_hz with people, otherwise none.
  double camera_hz = -1;
};

struct Job {
  std::string world;
  missions::MissionOptions options;
};

using Places = std::map<std::string, std::shared_ptr<const suites::SuitePlace>>;

absl::StatusOr<std::vector<Job>> JobsOf(const MissionFlags& flags) {
  TL_ASSIGN_OR_RETURN(const std::vector<uint64_t> seeds,
                      suites::ParseSeedList(flags.suite.seeds));
  missions::MissionOptions options;
  options.people = flags.suite.people;
  options.camera_hz = flags.camera_hz >= 0 ? flags.camera_hz
                      : flags.suite.people ? kPeopleCamera_hz
                                           : 0;
  options.has_rear_laser = !flags.suite.no_rear_laser;
  if (!flags.planner.empty()) {
    options.navigator.planner.planner = flags.planner;
  }
  TL_RETURN_IF_ERROR(options.navigator.Validate());
  std::vector<Job> jobs;
  const auto add = [&](const std::string& world) {
    for (const uint64_t seed : seeds) {
      options.seed = seed;
      jobs.push_back({world, options});
    }
  };
  for (const std::string& scene : flags.scenes) {
    options.scene = scene;
    add("cafe");
  }
  if (flags.scenes.empty()) {
    for (const std::string& world : flags.suite.worlds) add(world);
  }
  return jobs;
}

absl::StatusOr<Places> PlacesOf(const std::vector<Job>& jobs,
                                const MissionFlags& flags,
                                const std::stop_token& stop) {
  Places places;
  for (const Job& job : jobs) {
    auto& place = places[job.world];
    if (place != nullptr) continue;
    suites::SuiteMapOptions options = flags.suite.MapOptions(job.world);
    // Somebody must be there who can step in front.
    options.with_people |= !flags.scenes.empty();
    TL_ASSIGN_OR_RETURN(place, suites::PlaceForSuite(options, stop));
  }
  return places;
}

absl::Status WritePictures(const std::vector<missions::MissionRun>& runs,
                           const Places& places, const MissionFlags& flags) {
  int written = 0;
  for (const missions::MissionRun& run : runs) {
    if (!flags.suite.WantsPicture(run.IsGood())) continue;
    const auto place = std::ranges::find_if(places, [&run](const auto& entry) {
      return entry.second->world().name == run.world;
    });
    if (place == places.end()) continue;
    const std::string stem =
        absl::StrCat(flags.suite.folder, "/",
                     absl::StrReplaceAll(run.world, {{":", "-"}, {"/", "-"}}),
                     run.scene.empty() ? "" : "-", run.scene,
                     flags.suite.people ? "-people" : "", "-", run.seed);
    TL_RETURN_IF_ERROR(missions::WriteRunPicture(
        stem, place->second->world(), run.record, run.marks, run.events,
        absl::StrCat(missions::MissionOutcomeName(run.outcome), " (",
                     core::NavigationCauseName(run.cause), ") ", run.why, "; ",
                     run.surprise)));
    ++written;
  }
  if (written > 0) {
    std::printf("%d pictures and logs are in %s\n", written,
                flags.suite.folder.c_str());
  }
  return absl::OkStatus();
}

absl::Status RunMissions(const MissionFlags& flags,
                         const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const std::vector<Job> jobs, JobsOf(flags));
  if (!flags.suite.json.empty()) {
    TL_RETURN_IF_ERROR(base::CheckWritable(flags.suite.json));
  }
  TL_ASSIGN_OR_RETURN(const Places places, PlacesOf(jobs, flags, stop));
  suites::JobResults<missions::MissionRun> results =
      suites::RunJobs<missions::MissionRun>(
          jobs.size(), flags.suite.threads, "missions", flags.suite.quiet, stop,
          [&](size_t i) -> absl::StatusOr<missions::MissionRun> {
            const Job& job = jobs[i];
            absl::StatusOr<missions::MissionRun> run =
                missions::RunMission(*places.at(job.world), job.options, stop);
            if (run.ok()) return run;
            return base::Annotate(
                run.status(),
                absl::StrCat(job.world, ", seed ", job.options.seed));
          });
  const int expected = static_cast<int>(jobs.size());
  std::printf("%s", missions::MissionSummary(results.done, expected).c_str());
  if (!flags.suite.json.empty()) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        flags.suite.json,
        missions::MissionJson(results.done, expected, flags.suite.people)));
  }
  TL_RETURN_IF_ERROR(WritePictures(results.done, places, flags));
  return suites::SuiteStatus(
      results.done.size(), jobs.size(), missions::GoodShare(results.done),
      flags.suite.require, results.errors, results.first_error, stop);
}

}  // namespace

cli::Command AddMissionSuite(CLI::App& suite) {
  CLI::App* command = suite.add_subcommand(
      "missions",
      "Drives from place to place: who arrives, who runs into what");
  command->footer(kFooter);
  auto flags = std::make_shared<MissionFlags>();
  AddSuiteFlags(*command, "mission", flags->suite);
  command->add_flag("--people", flags->suite.people,
                    "People walk about, and something gets in the way");
  command
      ->add_option("--scenes", flags->scenes,
                   "The thesis's own missions in the cafe instead")
      ->type_name("slope,blocked,person")
      ->delimiter(',')
      ->check(CLI::IsMember(missions::MissionScenes()));
  command->add_option("--planner", flags->planner, "See treeline-agent plan")
      ->type_name("NAME");
  command
      ->add_option("--camera-hz", flags->camera_hz,
                   "Depth pictures of 160 x 120 pixels in a second; "
                   "5 with --people, otherwise 0")
      ->type_name("HZ")
      ->check(CLI::Range(0.0, 30.0));
  return {command, [flags](const std::stop_token& stop) {
            return RunMissions(*flags, stop);
          }};
}

}  // namespace treeline::suite_app
