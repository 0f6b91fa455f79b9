// treeline evaluate: localize a recording, and say how well it went.
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "server/tools/commands.h"
#include "server/tools/evaluate_flags.h"
#include "server/tools/evaluated_method.h"
#include "server/tools/evaluation_csv.h"
#include "server/tools/evaluation_json.h"
#include "server/tools/evaluation_table.h"
#include "server/tools/method_runner.h"
#include "server/tools/report.h"
#include "server/tools/run_info.h"

namespace treeline {
namespace {

constexpr const char* kDescription =
    "Localize every frame of a recording and compare with its ground truth";

constexpr const char* kFooter = R"(
The JSON and what its numbers mean: docs/evaluation.md. correct_* are fractions
of all frames with ground truth; latency is the localizer alone.

Examples:
  treeline evaluate --model kitchen.treeline --dataset 7scenes:data/kitchen \
      --frames data/kitchen/test.txt --poses data/kitchen/poses-sfm.txt \
      --json kitchen.json --report kitchen.html
  treeline evaluate --model rpy.treeline --dataset tum:data/rpy/test
  treeline evaluate --baseline orb-pnp \
      --training-dataset tum:data/rpy/train --dataset tum:data/rpy/test
  treeline evaluate --compare rgbd,brf,ubrf,sift-pnp,orb-pnp \
      --training-dataset tum:data/rpy/train --dataset tum:data/rpy/test \
      --sweep backtracking=1..16 --foreign builtin --report rpy.html)";

EvaluationRun DescribeRun(const EvaluateFlags& flags) {
  EvaluationRun run;
  run.dataset_uri = flags.dataset.uri;
  run.frame_list = flags.dataset.frame_list;
  run.pose_file = flags.dataset.pose_file;
  run.seed = flags.seed;
  run.threads = flags.threads;
  run.thresholds = flags.thresholds;
  run.confidence_threshold = flags.confidence_threshold;
  run.command = CommandLine();
  run.cpu = CpuDescription();
  run.software_version = Version();
  run.started_utc = UtcNow();
  return run;
}

absl::Status WriteOutputs(const EvaluateFlags& flags, ReportContents contents) {
  const EvaluationRun& run = contents.run;
  if (!flags.json_path.empty()) {
    TL_RETURN_IF_ERROR(WriteFileAtomically(
        flags.json_path,
        flags.comparing()
            ? ComparisonJson(contents.methods, contents.sweeps, run)
            : EvaluationJson(contents.methods.front(), contents.sweeps, run)));
  }
  if (!flags.csv_path.empty()) {
    TL_RETURN_IF_ERROR(
        WriteFileAtomically(flags.csv_path, EvaluationCsv(contents.methods)));
  }
  if (flags.report_path.empty()) return absl::OkStatus();
  return WriteFileAtomically(flags.report_path, ReportHtml(contents));
}

absl::Status RunEvaluate(const EvaluateFlags& flags,
                         const std::stop_token& stop) {
  for (const std::string& path :
       {flags.json_path, flags.csv_path, flags.report_path}) {
    if (!path.empty()) TL_RETURN_IF_ERROR(CheckWritable(path));
  }
  ReportContents contents;
  contents.run = DescribeRun(flags);
  TL_ASSIGN_OR_RETURN(MethodRunner runner, MethodRunner::Open(flags, stop));
  TL_ASSIGN_OR_RETURN(contents.methods, runner.EvaluateMethods());
  if (!flags.comparing()) {
    TL_RETURN_IF_ERROR(contents.methods.front().status);
  }
  std::vector<std::string> problems;
  for (const EvaluatedMethod& method : contents.methods) {
    if (method.status.ok()) continue;
    problems.push_back(
        absl::StrCat(method.name, ": ", std::string(method.status.message())));
  }
  TL_ASSIGN_OR_RETURN(contents.sweeps,
                      runner.RunSweeps(contents.methods, problems));
  contents.run.peak_memory_bytes = PeakMemoryBytes();
  std::fputs(
      flags.comparing()
          ? ComparisonTable(contents.methods, contents.run).c_str()
          : EvaluationTable(contents.methods.front(), contents.run).c_str(),
      stdout);
  std::fputs(SweepTable(contents.sweeps).c_str(), stdout);
  TL_RETURN_IF_ERROR(WriteOutputs(flags, std::move(contents)));
  if (problems.empty()) return absl::OkStatus();
  for (size_t i = 1; i < problems.size(); ++i) {
    std::fprintf(stderr, "%s\n", problems[i].c_str());
  }
  return absl::UnknownError(
      absl::StrCat(problems[0], " (the rest was evaluated)"));
}

}  // namespace

Command AddEvaluateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("evaluate", kDescription);
  command->footer(kFooter);
  auto flags = std::make_shared<EvaluateFlags>();
  AddEvaluateFlags(*command, *flags);
  // The options refer to the flags, which the closure keeps.
  return {command, [flags](const std::stop_token& stop) {
            return RunEvaluate(*flags, stop);
          }};
}

}  // namespace treeline
