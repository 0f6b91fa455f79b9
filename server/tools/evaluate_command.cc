// treeline evaluate: localize a recording, and say how well it went.
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "server/core/dataset/dataset.h"
#include "server/core/forest/model_info_json.h"
#include "server/core/localizer/localizer.h"
#include "server/tools/commands.h"
#include "server/tools/dataset_flags.h"
#include "server/tools/evaluation.h"
#include "server/tools/evaluation_json.h"
#include "server/tools/evaluation_table.h"
#include "server/tools/report.h"
#include "server/tools/run_info.h"
#include "server/tools/sift_pnp_baseline.h"

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
  treeline evaluate --baseline sift-pnp \
      --training-dataset tum:data/rpy/train --dataset tum:data/rpy/test)";

struct EvaluateFlags {
  std::string model_path;
  std::string baseline;
  std::string calibration_path;
  DatasetOptions dataset;
  DatasetOptions training;
  std::string json_path;
  std::string report_path;
  uint64_t seed = 0;
  int threads = 1;
  bool quiet = false;
  QueryOptions query;
  SiftPnpOptions sift;
};

void AddModelFlags(CLI::App& app, EvaluateFlags& flags) {
  constexpr const char* kGroup = "What to evaluate";
  app.add_option("--model", flags.model_path, "Model file of `treeline train`")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--baseline", flags.baseline,
                 "A yardstick instead of a model: sift-pnp (SIFT features of "
                 "training keyframes with depth or a structure, and PnP; needs "
                 "--training-dataset)")
      ->type_name("NAME")
      ->check(CLI::IsMember({"sift-pnp"}))
      ->group(kGroup);
  app.add_option("--calibration", flags.calibration_path,
                 "Calibration of `treeline calibrate`: of the queries, in "
                 "place of the model's, or of a baseline's keyframes")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--samples", flags.query.samples, "Pixels sampled a query")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--features", flags.query.features,
                 "SIFT features taken from a query (method sift, and sift-pnp "
                 "on a structure from motion)")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--leaves", flags.query.backtracking_leaves,
                 "Leaves that backtracking visits in each tree")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--hypotheses", flags.query.hypotheses,
                 "Pose hypotheses a query")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
}

void AddTrainingFlags(CLI::App& app, EvaluateFlags& flags) {
  constexpr const char* kGroup = "Training frames";
  app.add_option("--training-dataset", flags.training.uri,
                 "Recording that a baseline learns; with a model, where the "
                 "report finds its training cameras if what the model recorded "
                 "is not there")
      ->type_name("URI")
      ->group(kGroup);
  app.add_option("--training-frames", flags.training.frame_list,
                 "Its frame list")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--training-poses", flags.training.pose_file,
                 "Its poses, in place of its own")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--keyframes", flags.sift.keyframes,
                 "Training frames that a baseline keeps, evenly spread; 0: all")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
}

void AddOutputFlags(CLI::App& app, EvaluateFlags& flags) {
  constexpr const char* kGroup = "Running and output";
  app.add_option("--json", flags.json_path, "Write all results here")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--report", flags.report_path,
                 "Write a page with charts and pictures here (HTML)")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--seed", flags.seed, "Seed of every query")
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_option("--threads", flags.threads,
                 "Frames at a time; latencies mean something only with 1")
      ->check(CLI::Range(1, 1024))
      ->type_name("N")
      ->capture_default_str()
      ->group(kGroup);
  app.add_flag("--quiet", flags.quiet, "No progress bar")->group(kGroup);
}

// What CLI11 cannot say by itself. Throws, as its validators do.
void CheckUsage(const EvaluateFlags& flags) {
  if (flags.baseline.empty() && flags.model_path.empty()) {
    throw CLI::RequiredError("--model or --baseline");
  }
  if (!flags.baseline.empty() && flags.training.uri.empty()) {
    throw CLI::RequiredError("--training-dataset (for --baseline)");
  }
  if (flags.training.uri.empty() && (!flags.training.frame_list.empty() ||
                                     !flags.training.pose_file.empty())) {
    throw CLI::RequiredError(
        "--training-dataset (for --training-frames and --training-poses)");
  }
}

absl::StatusOr<RgbdCalibration> ReadCalibration(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string json, ReadFile(path, 1 << 20));
  absl::StatusOr<RgbdCalibration> calibration = CalibrationFromJson(json);
  if (!calibration.ok()) return Annotate(calibration.status(), path);
  return calibration;
}

// A run of the subcommand.
class EvaluateCommand {
 public:
  EvaluateCommand(const EvaluateFlags& flags, std::stop_token stop)
      : flags_(flags), stop_(std::move(stop)) {}

  absl::Status Run() {
    for (const std::string& path : {flags_.json_path, flags_.report_path}) {
      if (!path.empty()) TL_RETURN_IF_ERROR(CheckWritable(path));
    }
    run_.started_utc = UtcNow();
    TL_ASSIGN_OR_RETURN(const Dataset dataset, Dataset::Open(flags_.dataset));
    TL_RETURN_IF_ERROR(OpenTraining());
    TL_RETURN_IF_ERROR(MakeLocalizer());
    TL_ASSIGN_OR_RETURN(const EvaluationOptions options, Options(dataset));
    TL_ASSIGN_OR_RETURN(std::vector<FrameResult> results,
                        Evaluate(*localizer_, dataset, options, SteadyClock()));
    DescribeRun();
    std::fputs(EvaluationTable(results, localizer_->info()).c_str(), stdout);
    if (!flags_.json_path.empty()) {
      TL_RETURN_IF_ERROR(WriteFileAtomically(
          flags_.json_path, EvaluationJson(results, run_, localizer_->info())));
    }
    if (flags_.report_path.empty()) return absl::OkStatus();
    return WriteReport(dataset, options, std::move(results));
  }

 private:
  absl::Status OpenTraining() {
    if (flags_.training.uri.empty()) return absl::OkStatus();
    DatasetOptions options = flags_.training;
    options.color_camera = flags_.dataset.color_camera;
    options.depth_camera = flags_.dataset.depth_camera;
    options.depth_unit_m = flags_.dataset.depth_unit_m;
    options.max_time_difference_s = flags_.dataset.max_time_difference_s;
    TL_ASSIGN_OR_RETURN(training_, Dataset::Open(options));
    return absl::OkStatus();
  }

  absl::Status MakeLocalizer() {
    std::unique_ptr<Localizer> model;
    if (!flags_.model_path.empty()) {
      TL_ASSIGN_OR_RETURN(model,
                          OpenLocalizer(flags_.model_path, flags_.query));
    }
    if (!flags_.calibration_path.empty()) {
      TL_ASSIGN_OR_RETURN(calibration_,
                          ReadCalibration(flags_.calibration_path));
    }
    if (flags_.baseline.empty()) {
      localizer_ = std::move(model);
      return absl::OkStatus();
    }
    RgbdCalibration calibration = training_->calibration();
    if (model != nullptr) calibration = model->info().calibration;
    if (calibration_) calibration = *calibration_;
    SiftPnpOptions options = flags_.sift;
    options.structure_features = flags_.query.features;
    options.seed = flags_.seed;
    options.quiet = flags_.quiet;
    options.stop = stop_;
    TL_ASSIGN_OR_RETURN(localizer_,
                        BuildSiftPnpBaseline(*training_, calibration, options));
    return absl::OkStatus();
  }

  absl::StatusOr<EvaluationOptions> Options(const Dataset& dataset) const {
    EvaluationOptions options;
    options.seed = flags_.seed;
    options.threads = flags_.threads;
    options.quiet = flags_.quiet;
    options.stop = stop_;
    options.calibration = QueryCalibration(dataset, flags_.dataset,
                                           localizer_->info().calibration);
    if (calibration_ && flags_.baseline.empty()) {
      options.calibration = calibration_;
    }
    TL_RETURN_IF_ERROR(options.Validate());
    return options;
  }

  void DescribeRun() {
    run_.model_path = flags_.baseline.empty() ? flags_.model_path : "";
    run_.dataset_uri = flags_.dataset.uri;
    run_.frame_list = flags_.dataset.frame_list;
    run_.pose_file = flags_.dataset.pose_file;
    run_.seed = flags_.seed;
    run_.threads = flags_.threads;
    run_.command = CommandLine();
    run_.cpu = CpuDescription();
    run_.software_version = Version();
    run_.peak_memory_bytes = PeakMemoryBytes();
  }

  // The recording that the model says it was trained on, if it is still there:
  // a convenience for the report, whose absence is no error.
  std::optional<Dataset> RecordedTraining() const {
    const ModelInfo& info = localizer_->info();
    DatasetOptions options;
    options.uri = info.dataset;
    for (const auto& [name, value] : info.options) {
      if (name == "frames") options.frame_list = value;
      if (name == "poses") options.pose_file = value;
    }
    absl::StatusOr<Dataset> dataset = Dataset::Open(options);
    if (!dataset.ok()) return std::nullopt;
    return *std::move(dataset);
  }

  // Training poses of the model's pose sensor; empty if not known.
  std::vector<Rigid3> TrainingPoses() const {
    const std::optional<Dataset> training =
        training_ ? training_ : RecordedTraining();
    std::vector<Rigid3> poses;
    if (!training) return poses;
    const RgbdCalibration& calibration = localizer_->info().calibration;
    for (int i = 0; i < training->size(); ++i) {
      const std::optional<Rigid3>& pose = training->frame(i).world_from_camera;
      if (!pose) continue;
      poses.push_back(PoseOfSensor(*pose, training->calibration().pose_sensor,
                                   calibration.pose_sensor, calibration));
    }
    return poses;
  }

  absl::Status WriteReport(const Dataset& dataset,
                           const EvaluationOptions& options,
                           std::vector<FrameResult> results) {
    ReportContents contents;
    contents.run = run_;
    contents.model = localizer_->info();
    contents.results = std::move(results);
    contents.training_poses = TrainingPoses();
    contents.pictures = TakePictures(*localizer_, dataset,
                                     ChoosePictures(contents.results), options);
    if (stop_.stop_requested()) {
      return absl::CancelledError("evaluation was interrupted");
    }
    return WriteFileAtomically(flags_.report_path, ReportHtml(contents));
  }

  const EvaluateFlags& flags_;
  const std::stop_token stop_;
  std::optional<Dataset> training_;
  std::optional<RgbdCalibration> calibration_;  // of --calibration
  std::unique_ptr<Localizer> localizer_;
  EvaluationRun run_;
};

}  // namespace

Command AddEvaluateCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("evaluate", kDescription);
  command->footer(kFooter);
  auto flags = std::make_shared<EvaluateFlags>();
  AddModelFlags(*command, *flags);
  AddDatasetFlags(*command, flags->dataset);
  AddTrainingFlags(*command, *flags);
  AddOutputFlags(*command, *flags);
  command->parse_complete_callback([flags] { CheckUsage(*flags); });
  return {command, [flags](const std::stop_token& stop) {
            return EvaluateCommand(*flags, std::move(stop)).Run();
          }};
}

}  // namespace treeline
