#include "nav_agent/app/suite/field_suite_command.h"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "common/base/check_heading.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "evaluation/fields/field_report.h"
#include "evaluation/fields/field_suite.h"
#include "evaluation/fields/field_worlds.h"
#include "evaluation/suites/suite_jobs.h"
#include "evaluation/suites/suite_report.h"
#include "simulation/building/cylinder_field.h"
#include "simulation/building/moving_field.h"
#include "simulation/building/plan_file.h"
#include "simulation/worlds/world.h"

namespace treeline::suite_app {
namespace {

constexpr const char* kFooter = R"(
In the manner of the BARN challenge: a robot that knows nothing beforehand is
sent 10 m ahead, through a field of cylinders; 100 s, and a touch ends it. The
score of a run is 0 if the goal is not reached, else optimal time /
clip(time, 2 and 8 optimal times): 0.5 at best. docs/reference/suites.md
describes fields, score and the JSON file.

Examples:
  treeline-agent suite barn --fields 1-50
  treeline-agent suite barn --moving --fields 1-30
  treeline-agent suite barn --fields 3 --pictures all --folder out/barn
  treeline-agent suite barn --worlds mine.yaml,theirs.yaml --robot my-robot.yaml
  treeline-agent suite barn --worlds the-barn-challenge/jackal_helper/worlds/BARN
  treeline-agent suite barn --worlds hall.world --start 0,0,0 --goal 8,2
  treeline-agent suite barn --fields 1-300 --write-worlds out/fields)";

struct FieldFlags {
  std::string fields = "1-50";
  std::vector<std::string> worlds;
  std::vector<double> start;
  std::vector<double> goal;
  bool moving = false;
  std::string robot = "jackal";
  double speed_mps = 0;
  uint64_t seed = 0;
  int threads = 0;
  double require = 0;
  std::string json;
  std::string folder = "out/suite/barn";
  std::string pictures = "failed";
  std::string write_worlds;
  bool quiet = false;
};

struct Job {
  std::string world;
  uint64_t seed = 0;
};

absl::StatusOr<std::vector<Job>> JobsOf(const FieldFlags& flags) {
  std::vector<Job> jobs;
  for (const std::string& name : flags.worlds) {
    TL_ASSIGN_OR_RETURN(const std::vector<std::string> worlds,
                        fields::WorldsCalled(name));
    for (const std::string& world : worlds) jobs.push_back({world, flags.seed});
  }
  if (!jobs.empty()) return jobs;
  TL_ASSIGN_OR_RETURN(const std::vector<uint64_t> seeds,
                      suites::ParseSeedList(flags.fields));
  for (const uint64_t seed : seeds) {
    jobs.push_back(
        {absl::StrCat(flags.moving ? "moving-field:" : "field:", seed),
         seed + flags.seed});
  }
  return jobs;
}

absl::StatusOr<std::optional<fields::FieldEnds>> EndsOf(
    const FieldFlags& flags) {
  if (flags.start.empty() && flags.goal.empty()) return std::nullopt;
  if (flags.start.empty() || flags.goal.empty() || flags.worlds.empty()) {
    return absl::InvalidArgumentError(
        "--start and --goal go together, and with --worlds");
  }
  TL_RETURN_IF_ERROR(base::CheckHeading("--start", flags.start[2]));
  return fields::FieldEnds{
      .start = {.translation = {flags.start[0], flags.start[1]},
                .yaw_rad = flags.start[2]},
      .goal = {flags.goal[0], flags.goal[1]}};
}

absl::Status WriteWorlds(const FieldFlags& flags) {
  TL_ASSIGN_OR_RETURN(const std::vector<uint64_t> seeds,
                      suites::ParseSeedList(flags.fields));
  for (const uint64_t seed : seeds) {
    const std::string path =
        absl::StrCat(flags.write_worlds, "/field-", seed, ".yaml");
    TL_RETURN_IF_ERROR(base::MakeParentFolder(path));
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        path,
        building::PlanText(
            flags.moving
                ? building::MovingFieldPlan(building::DrawMovingField(seed))
                : building::FieldPlan(building::DrawField(seed)))));
  }
  std::printf("%d world files are in %s\n", static_cast<int>(seeds.size()),
              flags.write_worlds.c_str());
  return absl::OkStatus();
}

absl::Status WritePictures(const FieldFlags& flags,
                           const std::vector<fields::FieldRun>& runs) {
  for (const fields::FieldRun& run : runs) {
    if (flags.pictures == "none" ||
        (flags.pictures == "failed" && run.IsGood())) {
      continue;
    }
    TL_ASSIGN_OR_RETURN(
        const worlds::World world,
        worlds::MakeWorld(
            run.world, {.with_people = false, .threads = 1, .paint = false}));
    TL_RETURN_IF_ERROR(suites::WriteRunPicture(
        absl::StrCat(flags.folder, "/",
                     absl::StrReplaceAll(run.world, {{":", "-"}, {"/", "-"}})),
        world, run,
        absl::StrFormat("%s after %.1f s, score %.3f",
                        fields::FieldOutcomeName(run.outcome), run.time_s,
                        run.Score())));
  }
  return absl::OkStatus();
}

absl::Status RunFields(const FieldFlags& flags, const std::stop_token& stop) {
  if (!flags.write_worlds.empty()) return WriteWorlds(flags);
  fields::FieldOptions options;
  TL_ASSIGN_OR_RETURN(options.robot, core::ReadRobot(flags.robot));
  options.navigator.max_forward_mps = flags.speed_mps;
  options.with_movers = flags.moving;
  TL_ASSIGN_OR_RETURN(options.ends, EndsOf(flags));
  TL_ASSIGN_OR_RETURN(const std::vector<Job> jobs, JobsOf(flags));
  if (!flags.json.empty()) TL_RETURN_IF_ERROR(base::CheckWritable(flags.json));
  const suites::JobResults<fields::FieldRun> results =
      suites::RunJobs<fields::FieldRun>(
          jobs.size(), flags.threads, "fields", flags.quiet, stop,
          [&](size_t i) -> absl::StatusOr<fields::FieldRun> {
            fields::FieldOptions one = options;
            one.world = jobs[i].world;
            one.seed = jobs[i].seed;
            absl::StatusOr<fields::FieldRun> run = fields::RunField(one, stop);
            if (run.ok() ||
                absl::StrContains(run.status().message(), one.world)) {
              return run;
            }
            return base::Annotate(run.status(), one.world);
          });
  const int expected = static_cast<int>(jobs.size());
  std::printf("%s", fields::FieldSummary(results.done, expected).c_str());
  if (!flags.json.empty()) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        flags.json,
        fields::FieldJson(results.done, expected, options.robot.name)));
  }
  TL_RETURN_IF_ERROR(WritePictures(flags, results.done));
  return suites::SuiteStatus(results.done.size(), jobs.size(),
                             suites::GoodShare(results.done), flags.require,
                             results.errors, results.first_error, stop);
}

}  // namespace

cli::Command AddFieldSuite(CLI::App& suite) {
  CLI::App* command = suite.add_subcommand(
      "barn", "Drives through fields of cylinders that nothing is known of");
  command->footer(kFooter);
  auto flags = std::make_shared<FieldFlags>();
  command->add_option("--fields", flags->fields, "Which of the drawn fields")
      ->type_name("FIRST-LAST,...")
      ->capture_default_str();
  command
      ->add_option("--worlds", flags->worlds,
                   "These instead: worlds with places 'start' and 'goal', "
                   "worlds of Gazebo (.world, .sdf), and folders of files")
      ->type_name("WORLD,...")
      ->delimiter(',');
  command
      ->add_option("--start", flags->start,
                   "Where the robot starts in --worlds (m, rad), in the file's "
                   "own coordinates; otherwise the place 'start', of worlds of "
                   "Gazebo the challenge's -2.25,3,1.57")
      ->type_name("X,Y,YAW")
      ->delimiter(',')
      ->expected(3);
  command
      ->add_option("--goal", flags->goal,
                   "Where it is sent to then; otherwise the place 'goal', or "
                   "-2.25,13")
      ->type_name("X,Y")
      ->delimiter(',')
      ->expected(2);
  command->add_flag("--moving", flags->moving,
                    "Fields in which cylinders move, 20 m across, in the "
                    "manner of DynaBARN; of --worlds: what moves there moves");
  command
      ->add_option(
          "--robot", flags->robot,
          "rmp100, jackal, turtlebot3, or a file (docs/reference/robots.md)")
      ->type_name("ROBOT")
      ->capture_default_str();
  command
      ->add_option("--speed", flags->speed_mps,
                   "At most so fast (m/s); 0: the robot's own")
      ->check(CLI::Range(0.0, 5.0));
  command->add_option("--seed", flags->seed,
                      "Of the noise, beside the field's number");
  command
      ->add_option("--threads", flags->threads,
                   "How many at a time; 0: one a processor")
      ->check(CLI::Range(0, 1024));
  command
      ->add_option("--require", flags->require,
                   "Fail if a smaller share of the fields is reached")
      ->type_name("SHARE")
      ->check(CLI::Range(0.0, 1.0));
  command->add_option("--json", flags->json, "Write all figures")
      ->type_name("FILE");
  command->add_option("--folder", flags->folder, "Where pictures and logs go")
      ->type_name("FOLDER")
      ->capture_default_str();
  command->add_option("--pictures", flags->pictures, "Of which fields")
      ->check(CLI::IsMember({"none", "failed", "all"}))
      ->capture_default_str();
  command
      ->add_option("--write-worlds", flags->write_worlds,
                   "Write the fields as world files, and drive nothing")
      ->type_name("FOLDER");
  command->add_flag("--quiet", flags->quiet, "Show no progress");
  return {command, [flags](const std::stop_token& stop) {
            return RunFields(*flags, stop);
          }};
}

}  // namespace treeline::suite_app
