#include "nav_agent/app/plan/plan_command.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "nav_agent/app/plan/plan_drawing.h"
#include "nav_agent/app/plan/plan_run.h"

namespace treeline::plan_app {
namespace {

constexpr const char* kFooter = R"(
Draws the plan beside the JSON file (or where --picture says): the trees as they
were when the first path was found in blue and green, the path in red, the
footprint where it starts and ends. That there is no path is a result with a
cause: start_blocked, goal_blocked, goal_outside, no_path or plan_timeout; the
files are written all the same, and the exit code is 1.
docs/explanation/planning.md describes the method.

Examples:
  treeline-agent plan --world cafe --start 1,1,0 --goal 11,8,1.57 \
      --json plan.json
  treeline-agent plan --map house --start 0,0,0,0 --goal 3,2,0,1 \
      --planner bit-star --time 0.5 --block 1.5,1,0.3 --json plan.json)";

struct PlanFlags {
  std::string map;
  std::string world;
  std::string start;
  std::string goal;
  std::vector<std::string> blocks;
  std::string json;
  std::string picture;
  double time_s = 0.1;
  uint64_t seed = 1;
  bool allow_unknown = false;
  planning::GlobalPlannerOptions options;
};

absl::StatusOr<PlanReport> RequestOf(const PlanFlags& flags) {
  PlanReport report;
  report.map_name = flags.map.empty() ? flags.world : flags.map;
  report.planner = flags.options.planner;
  TL_ASSIGN_OR_RETURN(report.request.start,
                      ParsePlanPose(flags.start, "--start"));
  TL_ASSIGN_OR_RETURN(report.request.goal, ParsePlanPose(flags.goal, "--goal"));
  for (const std::string& text : flags.blocks) {
    TL_ASSIGN_OR_RETURN(const planning::Blockage blockage, ParseBlockage(text));
    report.request.blockages.push_back(blockage);
  }
  report.request.seed = flags.seed;
  return report;
}

absl::Status Run(PlanFlags& flags, const std::stop_token& stop) {
  if (flags.map.empty() == flags.world.empty()) {
    return absl::InvalidArgumentError(
        "give either --map (a .yaml map or a bundle's folder) or --world");
  }
  if (!(flags.time_s > 0 && flags.time_s <= 3600)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--time is ", flags.time_s, "; it must be above 0 and at most 3600 s"));
  }
  TL_ASSIGN_OR_RETURN(PlanReport report, RequestOf(flags));
  if (flags.picture.empty()) {
    flags.picture =
        std::filesystem::path(flags.json).replace_extension(".png").string();
  }
  TL_RETURN_IF_ERROR(base::CheckWritable(flags.json));
  TL_RETURN_IF_ERROR(base::CheckWritable(flags.picture));
  TL_ASSIGN_OR_RETURN(
      const std::shared_ptr<const traversability::NavigationMap> map,
      flags.map.empty() ? NavigationMapOfWorld(flags.world, flags.allow_unknown)
                        : LoadNavigationMap(flags.map, flags.allow_unknown));
  const core::RobotModel robot;
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<planning::GlobalPlanner> planner,
                      planning::MakeGlobalPlanner(map, robot, flags.options));
  TL_ASSIGN_OR_RETURN(
      report.result,
      planner->Plan(
          report.request,
          {.max_iterations = 1'000'000'000, .max_time_s = flags.time_s}, stop));
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(flags.json, PlanJson(report)));
  TL_ASSIGN_OR_RETURN(const std::string png,
                      image::EncodePng(DrawPlanReport(*map, robot, report)));
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(flags.picture, png));
  if (report.result.failure != core::NavigationCause::kNone) {
    return absl::NotFoundError(
        absl::StripTrailingAsciiWhitespace(PlanSummary(report)));
  }
  std::printf("%sWritten to %s and %s\n", PlanSummary(report).c_str(),
              flags.json.c_str(), flags.picture.c_str());
  return absl::OkStatus();
}

void AddOptions(CLI::App& command, PlanFlags& flags) {
  command
      .add_option("--map", flags.map,
                  "A map_server map (.yaml), or a map bundle's folder")
      ->type_name("PATH");
  command
      .add_option("--world", flags.world,
                  "Or a synthetic world, as simulate takes it")
      ->type_name("NAME");
  command
      .add_option("--start", flags.start,
                  "Where the robot is: m, rad, and the level from 0")
      ->type_name("X,Y,YAW[,LEVEL]")
      ->required();
  command.add_option("--goal", flags.goal, "Where it shall be")
      ->type_name("X,Y,YAW[,LEVEL]")
      ->required();
  command
      .add_option("--block", flags.blocks,
                  "A disc to keep out of, not on the map; may be repeated")
      ->type_name("X,Y,R[,LEVEL]");
  command
      .add_option("--planner", flags.options.planner,
                  "variable-rrt, or of OMPL: rrt-connect, rrt-star, bit-star, "
                  "informed-rrt-star, ompl-variable-rrt")
      ->type_name("NAME")
      ->capture_default_str();
  command
      .add_option("--time", flags.time_s,
                  "Seconds to look for a path and to improve it")
      ->type_name("S")
      ->capture_default_str();
  command
      .add_option("--margin", flags.options.margin_m,
                  "Room beside the footprint")
      ->type_name("M")
      ->capture_default_str();
  command.add_option("--seed", flags.seed, "Of the random numbers")
      ->capture_default_str();
  command.add_flag("--allow-unknown", flags.allow_unknown,
                   "Drive over cells that are unknown, too");
  command.add_option("--json", flags.json, "The result")
      ->type_name("FILE")
      ->required();
  command
      .add_option("--picture", flags.picture,
                  "Its picture; by default beside the result, .png")
      ->type_name("FILE");
}

}  // namespace

cli::Command AddPlanCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("plan", "Plan a way over a map, and draw it");
  command->footer(kFooter);
  auto flags = std::make_shared<PlanFlags>();
  AddOptions(*command, *flags);
  return {command,
          [flags](const std::stop_token& stop) { return Run(*flags, stop); }};
}

}  // namespace treeline::plan_app
