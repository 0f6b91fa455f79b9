#include "nav_agent/app/suite/mission_suite_command.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/base/status_macros.h"
#include "evaluation/missions/mission_report.h"
#include "evaluation/missions/mission_suite.h"
#include "evaluation/suites/suite_runner.h"
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
  suites::SuiteOptions suite = {
      .worlds = {"cafe", "lab", "two-storey", "seed:17"},
      .seeds = "1-50",
      .maps = "perfect",
      .folder = "out/suite/missions"};
  std::vector<std::string> scenes;
  std::string planner;
  // Negative: kPeopleCamera_hz with people, otherwise none.
  double camera_hz = -1;
};

absl::StatusOr<missions::MissionOptions> MissionOptionsOf(
    const MissionFlags& flags) {
  missions::MissionOptions options;
  options.people = flags.suite.people;
  options.camera_hz = flags.camera_hz >= 0 ? flags.camera_hz
                      : flags.suite.people ? kPeopleCamera_hz
                                           : 0;
  TL_ASSIGN_OR_RETURN(options.robot, core::ReadRobot(flags.suite.robot));
  options.has_rear_laser = !flags.suite.no_rear_laser;
  if (!flags.planner.empty()) {
    options.navigator.planner.planner = flags.planner;
  }
  TL_RETURN_IF_ERROR(options.navigator.Validate());
  return options;
}

absl::StatusOr<std::vector<suites::SuiteJob>> JobsOf(
    const MissionFlags& flags) {
  TL_ASSIGN_OR_RETURN(const std::vector<uint64_t> seeds,
                      suites::ParseSeedList(flags.suite.seeds));
  if (flags.scenes.empty()) return suites::JobsOf(flags.suite.worlds, seeds);
  std::vector<suites::SuiteJob> jobs;
  for (const std::string& scene : flags.scenes) {
    for (suites::SuiteJob& job : suites::JobsOf({"cafe"}, seeds, scene)) {
      jobs.push_back(std::move(job));
    }
  }
  return jobs;
}

suites::RunPictureText PictureText(const missions::MissionRun& run,
                                   const MissionFlags& flags) {
  return {.stem = absl::StrCat(
              absl::StrReplaceAll(run.world, {{":", "-"}, {"/", "-"}}),
              run.scene.empty() ? "" : "-", run.scene,
              flags.suite.people ? "-people" : "", "-", run.seed),
          .title = absl::StrCat(missions::MissionOutcomeName(run.outcome), " (",
                                core::NavigationCauseName(run.cause), ") ",
                                run.why, "; ", run.surprise)};
}

absl::Status RunMissions(const MissionFlags& flags,
                         const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const missions::MissionOptions options,
                      MissionOptionsOf(flags));
  suites::Suite<missions::MissionRun> suite;
  suite.name = "missions";
  TL_ASSIGN_OR_RETURN(suite.jobs, JobsOf(flags));
  const auto map_options = [&](const std::string& world) {
    suites::SuiteMapOptions map = flags.suite.MapOptions(world);
    map.robot_radius_m = suites::PlaceRadius_m(options.robot->model);
    // Somebody must be there who can step in front.
    map.with_people |= !flags.scenes.empty();
    return map;
  };
  TL_ASSIGN_OR_RETURN(
      const suites::SuitePlaces places,
      suites::PrepareSuite(suite.jobs, flags.suite, map_options, stop));
  const int expected = static_cast<int>(suite.jobs.size());
  suite.run = [&](const suites::SuiteJob& job,
                  const suites::SuitePlace& place) {
    missions::MissionOptions mission = options;
    mission.seed = job.seed;
    mission.scene = job.scene;
    return missions::RunMission(place, mission, stop);
  };
  suite.summary = [&](const std::vector<missions::MissionRun>& runs) {
    return missions::MissionSummary(runs, expected);
  };
  suite.json = [&](const std::vector<missions::MissionRun>& runs) {
    return missions::MissionJson(runs, expected, flags.suite.people,
                                 flags.suite.rearranged);
  };
  suite.picture = [&](const missions::MissionRun& run) {
    return PictureText(run, flags);
  };
  return suites::RunSuite(suite, places, flags.suite, stop);
}

}  // namespace

cli::Command AddMissionSuite(CLI::App& suite) {
  CLI::App* command = suite.add_subcommand(
      "missions",
      "Drives from place to place: who arrives, who runs into what");
  command->footer(kFooter);
  auto flags = std::make_shared<MissionFlags>();
  AddSuiteFlags(*command, "mission", flags->suite);
  AddRobotFlag(*command, flags->suite);
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
