#include "server/tools/app/evaluate_command.h"

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
#include "evaluation/accuracy/evaluate_flags.h"
#include "evaluation/accuracy/evaluated_method.h"
#include "evaluation/accuracy/evaluation_csv.h"
#include "evaluation/accuracy/evaluation_json.h"
#include "evaluation/accuracy/evaluation_table.h"
#include "evaluation/accuracy/method_runner.h"
#include "evaluation/accuracy/perturbation.h"
#include "evaluation/accuracy/perturbation_table.h"
#include "evaluation/report/report.h"
#include "evaluation/report/report_page.h"
#include "server/tools/run_info.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kDescription =
    "Localize every frame of a recording and compare with its ground truth";

constexpr const char* kPerturbations = R"(
Perturbations and their usual strengths s:
)";

constexpr const char* kFooter = R"(
The JSON and what its numbers mean: docs/reference/evaluation.md. correct_* are
fractions of all frames with ground truth; latency is the localizer alone.

Examples:
  treeline evaluate --model kitchen.treeline --dataset 7scenes:data/kitchen \
      --frames data/kitchen/test.txt --poses data/kitchen/poses-sfm.txt \
      --json kitchen.json --report kitchen.html
  treeline evaluate --model rpy.treeline --dataset tum:data/rpy/test
  treeline evaluate --baseline orb-pnp \
      --training-dataset tum:data/rpy/train --dataset tum:data/rpy/test
  treeline evaluate --compare rgbd,brf,ubrf,sift-pnp,orb-pnp \
      --training-dataset tum:data/rpy/train --dataset tum:data/rpy/test \
      --sweep backtracking=1..16 --foreign builtin --report rpy.html
  treeline evaluate --compare new=rpy.treeline,sift-pnp,orb-pnp \
      --training-dataset tum:data/rpy/train --dataset tum:data/rpy/test \
      --perturb gamma,blur:12,no-depth+cover --perturb-frames 40)";

accuracy::EvaluationRun DescribeRun(const accuracy::EvaluateFlags& flags) {
  accuracy::EvaluationRun run;
  run.dataset_uri = flags.dataset.uri;
  run.frame_list = flags.dataset.frame_list;
  run.pose_file = flags.dataset.pose_file;
  run.seed = flags.seed;
  run.threads = flags.threads;
  run.thresholds = flags.thresholds;
  run.confidence_threshold = flags.confidence_threshold;
  run.min_confidence = flags.min_confidence;
  run.command = tools::CommandLine();
  run.cpu = tools::CpuDescription();
  run.software_version = base::Version();
  run.started_utc = tools::UtcNow();
  return run;
}

absl::Status WriteOutputs(const accuracy::EvaluateFlags& flags,
                          const report::ReportContents& contents,
                          const std::string& report_template) {
  const accuracy::EvaluationRun& run = contents.run;
  if (!flags.json_path.empty()) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        flags.json_path,
        flags.comparing()
            ? accuracy::ComparisonJson(contents.methods, contents.sweeps, run)
            : accuracy::EvaluationJson(contents.methods.front(),
                                       contents.sweeps, run)));
  }
  if (!flags.csv_path.empty()) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        flags.csv_path, accuracy::EvaluationCsv(contents.methods)));
  }
  if (flags.report_path.empty()) return absl::OkStatus();
  return report::WriteReport(flags.report_path, report::ReportJson(contents),
                             report_template);
}

absl::Status RunEvaluate(const accuracy::EvaluateFlags& flags,
                         const std::stop_token& stop) {
  for (const std::string& path :
       {flags.json_path, flags.csv_path, flags.report_path}) {
    if (!path.empty()) TL_RETURN_IF_ERROR(base::CheckWritable(path));
  }
  // Said before the work, not after it.
  const std::string report_template = report::FindReportTemplate();
  if (!flags.report_path.empty() && report_template.empty()) {
    std::fputs(report::NoTemplateNotice(flags.report_path).c_str(), stderr);
  }
  report::ReportContents contents;
  contents.run = DescribeRun(flags);
  TL_ASSIGN_OR_RETURN(accuracy::MethodRunner runner,
                      accuracy::MethodRunner::Open(flags, stop));
  TL_ASSIGN_OR_RETURN(contents.methods, runner.EvaluateMethods());
  if (!flags.comparing()) {
    TL_RETURN_IF_ERROR(contents.methods.front().status);
  }
  std::vector<std::string> problems;
  for (const accuracy::EvaluatedMethod& method : contents.methods) {
    if (method.status.ok()) continue;
    problems.push_back(
        absl::StrCat(method.name, ": ", std::string(method.status.message())));
  }
  TL_ASSIGN_OR_RETURN(contents.sweeps,
                      runner.RunSweeps(contents.methods, problems));
  contents.run.peak_memory_bytes = tools::PeakMemoryBytes();
  std::fputs(
      flags.comparing()
          ? accuracy::ComparisonTable(contents.methods, contents.run).c_str()
          : accuracy::EvaluationTable(contents.methods.front(), contents.run)
                .c_str(),
      stdout);
  std::fputs(
      accuracy::PerturbationTable(contents.methods, contents.run).c_str(),
      stdout);
  std::fputs(accuracy::SweepTable(contents.sweeps).c_str(), stdout);
  TL_RETURN_IF_ERROR(WriteOutputs(flags, contents, report_template));
  if (problems.empty()) return absl::OkStatus();
  for (size_t i = 1; i < problems.size(); ++i) {
    std::fprintf(stderr, "%s\n", problems[i].c_str());
  }
  return absl::UnknownError(
      absl::StrCat(problems[0], " (the rest was evaluated)"));
}

}  // namespace

cli::Command AddEvaluateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("evaluate", kDescription);
  command->footer(
      absl::StrCat(kPerturbations, accuracy::PerturbationHelp(), kFooter));
  auto flags = std::make_shared<accuracy::EvaluateFlags>();
  accuracy::AddEvaluateFlags(*command, *flags);
  // The options refer to the flags, which the closure keeps.
  return {command, [flags](const std::stop_token& stop) {
            return RunEvaluate(*flags, stop);
          }};
}

}  // namespace treeline::tools_app
