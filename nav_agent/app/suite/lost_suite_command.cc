#include "nav_agent/app/suite/lost_suite_command.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "common/base/file.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "evaluation/lost/lost_fit.h"
#include "evaluation/lost/lost_suite.h"
#include "evaluation/lost/lost_suite_picture.h"
#include "evaluation/lost/lost_suite_report.h"
#include "evaluation/suites/suite_jobs.h"
#include "nav_agent/app/suite/suite_flags.h"
#include "simulation/worlds/world_flags.h"

namespace treeline::suite_app {
namespace {

constexpr const char* kFooter = R"(
Each world and seed is one simulation: a drive along the tour among people, with
furniture moved since the map was made, then kidnaps.
docs/research/lost-detection.md says how they are counted.

Examples:
  treeline-agent suite lost --seeds 1-4 --json lost.json --picture lost.png
  treeline-agent suite lost --worlds seed:1,seed:2 --features table.csv
  treeline-agent suite lost-fit --features table.csv)";

struct LostFlags {
  std::vector<std::string> worlds = {"cafe", "lab", "office-floor",
                                     "two-storey", "seed:17"};
  std::string seeds = "1-20";
  double minutes = 6;
  int kidnaps = 10;
  worlds::Rearrangement rearranged;
  std::string json;
  std::string picture;
  std::string features;
  bool quiet = false;
};

absl::StatusOr<std::vector<lost::LostRun>> RunAll(
    const LostFlags& flags, const std::vector<uint64_t>& seeds,
    const std::stop_token& stop) {
  lost::LostRunOptions options;
  options.drive_s = 60 * flags.minutes;
  options.kidnaps = flags.kidnaps;
  options.rearranged = flags.rearranged;
  const double runs = static_cast<double>(flags.worlds.size()) *
                      static_cast<double>(seeds.size());
  base::Progress progress(
      "simulating",
      1 + static_cast<int64_t>(runs * lost::ExpectedSeconds(options)),
      flags.quiet);
  double passed_s = 0;
  int64_t shown = 0;
  const auto pass = [&](double seconds) {
    passed_s += seconds;
    progress.Add(static_cast<int64_t>(passed_s) - shown);
    shown = static_cast<int64_t>(passed_s);
  };
  std::vector<lost::LostRun> done;
  for (const std::string& name : flags.worlds) {
    TL_ASSIGN_OR_RETURN(
        const worlds::World world,
        worlds::MakeWorld(
            name, {.with_people = false, .threads = 1, .paint = false}));
    TL_ASSIGN_OR_RETURN(
        const runs::SuiteWorld map,
        runs::SuiteWorld::Create(
            world, core::RobotModel().base_from_laser.translation.z));
    options.world = name;
    for (const uint64_t seed : seeds) {
      options.seed = seed;
      TL_ASSIGN_OR_RETURN(lost::LostRun run,
                          lost::RunLostSuite(map, options, pass, stop));
      done.push_back(std::move(run));
    }
  }
  return done;
}

absl::Status RunLost(const LostFlags& flags, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const std::vector<uint64_t> seeds,
                      suites::ParseSeedList(flags.seeds));
  for (const std::string* path :
       {&flags.json, &flags.picture, &flags.features}) {
    if (!path->empty()) TL_RETURN_IF_ERROR(base::CheckWritable(*path));
  }
  TL_ASSIGN_OR_RETURN(std::vector<lost::LostRun> runs,
                      RunAll(flags, seeds, stop));
  const double declare_at = localization::LostDetectorOptions().declare_at;
  const lost::LostReport report(std::move(runs),
                                std::log(declare_at / (1 - declare_at)));
  std::printf("%s", report.Summary().c_str());
  if (!flags.json.empty()) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(flags.json, report.Json()));
  }
  if (!flags.features.empty()) {
    TL_RETURN_IF_ERROR(
        base::WriteFileAtomically(flags.features, report.FeatureTable()));
  }
  if (flags.picture.empty()) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::string png,
                      image::EncodePng(lost::DrawLostReport(report)));
  return base::WriteFileAtomically(flags.picture, png);
}

absl::Status RunFit(const std::vector<std::string>& paths) {
  std::string table;
  for (const std::string& path : paths) {
    TL_ASSIGN_OR_RETURN(const std::string text, base::ReadFile(path));
    // One header for all of them.
    const size_t body = text.find('\n');
    if (table.empty()) {
      table = text;
    } else if (body != std::string::npos) {
      table += text.substr(body + 1);
    }
  }
  TL_ASSIGN_OR_RETURN(const localization::LostModel model,
                      lost::FitLostModel(table));
  std::printf("%s", lost::LostModelText(model).c_str());
  return absl::OkStatus();
}

}  // namespace

cli::Command AddLostSuite(CLI::App& suite) {
  CLI::App* command = suite.add_subcommand(
      "lost", "Kidnaps and false alarms of the lost detector");
  command->footer(kFooter);
  auto flags = std::make_shared<LostFlags>();
  AddWorldFlags(*command, "run", flags->worlds, flags->seeds);
  command->add_option("--minutes", flags->minutes, "Of driving in each run")
      ->type_name("N")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  command->add_option("--kidnaps", flags->kidnaps, "In each run, after that")
      ->type_name("N")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  worlds::AddRearrangedFlag(*command, flags->rearranged);
  command->add_option("--json", flags->json, "Write all figures")
      ->type_name("FILE");
  command->add_option("--picture", flags->picture, "Draw the ROC and delays")
      ->type_name("FILE.png");
  command
      ->add_option("--features", flags->features,
                   "Write evidence and truth of scans, for lost-fit")
      ->type_name("FILE.csv");
  command->add_flag("--quiet", flags->quiet, "Show no progress");
  return {command, [flags](const std::stop_token& stop) {
            return RunLost(*flags, stop);
          }};
}

cli::Command AddLostFit(CLI::App& suite) {
  CLI::App* command =
      suite.add_subcommand("lost-fit", "Fit the weights of the lost detector");
  auto paths = std::make_shared<std::vector<std::string>>();
  command->add_option("--features", *paths, "What suite lost wrote")
      ->type_name("FILE.csv")
      ->required();
  return {command,
          [paths](const std::stop_token& /*stop*/) { return RunFit(*paths); }};
}

}  // namespace treeline::suite_app
