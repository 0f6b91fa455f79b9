#include "server/tools/app/recognize_command.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "evaluation/accuracy/scene_recognition.h"
#include "evaluation/accuracy/scene_recognition_output.h"
#include "evaluation/report/report_page.h"
#include "server/tools/run_info.h"

namespace treeline::tools_app {
namespace {

constexpr const char* kFooter = R"(
Every frame is asked about without the scene's name: scenes are ranked by what
they look like, and poses in the first few decide. Columns: the true scene
ranked first, and among the first three; right: it answered; located: it
answered with a pose; wrong: another scene answered with a pose (frames); tried:
scenes in which a pose was looked for, on average.

Examples:
  treeline recognize --models models --query kitchen=7scenes:kitchen,test.txt \
      --query desk=tum:desk/test --foreign builtin --report scenes.html
  treeline recognize --models models --scene kitchen --dataset 7scenes:kitchen \
      --frames test.txt --rank-only --json kitchen.json)";

struct RecognizeFlags {
  std::string models_folder;
  std::vector<std::string> queries;
  std::vector<std::string> foreign;
  std::string scene;
  dataset::DatasetOptions dataset;
  std::string json_path;
  std::string report_path;
  accuracy::RecognitionOptions options;
};

absl::StatusOr<std::vector<accuracy::RecognitionQuery>> Queries(
    const RecognizeFlags& flags) {
  std::vector<accuracy::RecognitionQuery> queries;
  if (flags.scene.empty() != flags.dataset.uri.empty()) {
    return absl::InvalidArgumentError("--scene and --dataset go together");
  }
  if (!flags.scene.empty()) {
    accuracy::RecognitionQuery query;
    query.scene = flags.scene;
    query.source.name = flags.dataset.uri;
    query.source.dataset = flags.dataset;
    queries.push_back(std::move(query));
  }
  for (const std::string& text : flags.queries) {
    TL_ASSIGN_OR_RETURN(accuracy::RecognitionQuery query,
                        accuracy::ParseRecognitionQuery(text));
    queries.push_back(std::move(query));
  }
  for (const std::string& text : flags.foreign) {
    accuracy::RecognitionQuery query;
    TL_ASSIGN_OR_RETURN(query.source, accuracy::ParseForeignSource(text));
    queries.push_back(std::move(query));
  }
  if (queries.empty()) {
    return absl::InvalidArgumentError(
        "nothing to ask about: give --query, --scene or --foreign");
  }
  return queries;
}

absl::Status RunRecognize(const RecognizeFlags& flags,
                          const std::stop_token& stop) {
  for (const std::string& path : {flags.json_path, flags.report_path}) {
    if (!path.empty()) TL_RETURN_IF_ERROR(base::CheckWritable(path));
  }
  const std::string report_template = report::FindReportTemplate();
  if (!flags.report_path.empty() && report_template.empty()) {
    std::fputs(report::NoTemplateNotice(flags.report_path).c_str(), stderr);
  }
  TL_ASSIGN_OR_RETURN(const std::vector<accuracy::RecognitionQuery> queries,
                      Queries(flags));
  accuracy::RecognitionRun run;
  run.command = tools::CommandLine();
  run.cpu = tools::CpuDescription();
  run.software_version = base::Version();
  run.started_utc = tools::UtcNow();
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<accuracy::SceneModels> models,
                      accuracy::SceneModels::Open(flags.models_folder));
  run.scenes = models->scenes();
  run.read_ms = models->read_ms();
  run.options = flags.options;
  run.options.stop = stop;
  TL_ASSIGN_OR_RETURN(
      const std::vector<accuracy::RecognitionTally> tallies,
      accuracy::Recognize(*models, queries, run.options, base::SteadyClock()));
  std::fputs(accuracy::RecognitionTable(tallies, run).c_str(), stdout);
  if (!flags.json_path.empty()) {
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(
        flags.json_path, accuracy::RecognitionJson(tallies, run)));
  }
  if (flags.report_path.empty()) return absl::OkStatus();
  return report::WriteReport(flags.report_path,
                             accuracy::RecognitionReportJson(tallies, run),
                             report_template);
}

void AddFlags(CLI::App& app, RecognizeFlags& flags) {
  const auto add = [&](const char* name, auto& value, const char* help,
                       const char* type) {
    return app.add_option(name, value, help)->type_name(type);
  };
  add("--models", flags.models_folder,
      "Folder of models, DIR/<scene>/<version>/model.treeline; the newest of "
      "each scene counts",
      "DIR")
      ->required();
  add("--query", flags.queries,
      "Frames of a recording, and the scene they were taken in; may be given "
      "many times",
      "SCENE=URI[,FRAMES]")
      ->take_all();
  add("--scene", flags.scene, "The scene of --dataset", "NAME");
  add("--dataset", flags.dataset.uri, "As in `treeline evaluate`", "URI");
  add("--frames", flags.dataset.frame_list, "Frames of --dataset", "FILE");
  add("--foreign", flags.foreign,
      "Pictures of no scene: builtin, builtin,N, URI or URI,FRAMES; may be "
      "given many times",
      "SOURCE")
      ->take_all();
  add("--max-tried", flags.options.among.max_tried,
      "Scenes in which a pose is looked for, at most", "N")
      ->capture_default_str();
  add("--sure-confidence", flags.options.among.sure_confidence,
      "A pose of this confidence ends the search", "P")
      ->capture_default_str();
  app.add_flag("--rank-only", flags.options.rank_only, "Look for no poses");
  app.add_flag("--no-depth", flags.options.no_depth,
               "Leave the depth of frames away");
  add("--every", flags.options.every, "Take every N-th frame", "N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  add("--seed", flags.options.seed, "Of the queries", "N")
      ->capture_default_str();
  add("--threads", flags.options.threads,
      "Frames at a time; times mean something with 1 only", "N")
      ->capture_default_str();
  add("--json", flags.json_path, "Write all figures and every frame's", "FILE");
  add("--report", flags.report_path, "Write a page with the confusion matrix",
      "FILE");
  app.add_flag("--quiet", flags.options.quiet, "Show no progress");
}

}  // namespace

cli::Command AddRecognizeCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "recognize", "Measure how often the right scene is found among many");
  command->footer(kFooter);
  auto flags = std::make_shared<RecognizeFlags>();
  AddFlags(*command, *flags);
  return {command, [flags](const std::stop_token& stop) {
            return RunRecognize(*flags, stop);
          }};
}

}  // namespace treeline::tools_app
