#include "server/tools/app/learn_run.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/dataset/frame_use.h"
#include "common/image/decode.h"
#include "server/core/forest/model_file.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/training/rgbd_calibrator.h"
#include "server/core/training/scene_trainer.h"
#include "server/repository/names.h"
#include "server/tools/app/learn_evaluation.h"
#include "server/tools/app/learn_import.h"
#include "server/tools/calibration_file.h"
#include "server/tools/coverage_picture.h"
#include "server/tools/learning/learn_page.h"
#include "server/tools/learning/learn_source.h"
#include "server/tools/model_description.h"
#include "server/tools/output_folder.h"
#include "server/tools/run_info.h"
#include "server/tools/training_place.h"
#include "server/tools/training_record.h"

namespace treeline::tools_app {
namespace {

using dataset::Dataset;
using dataset::DatasetOptions;
using learning::SourceKind;
using tools::OutputFolder;

// With fewer, what is held out says nothing, and what is learnt is little.
constexpr int kFewestFrames = 20;
constexpr int kWeakSpots = 4;
constexpr int kSteps = 7;
constexpr uint64_t kMaxModelBytes = uint64_t{16} << 30;
constexpr const char* kPage = "page.html";

// Says which step begins and what came of it, and keeps both for the page.
class Steps {
 public:
  explicit Steps(bool quiet) : quiet_(quiet) {}

  void Begin(const std::string& name) {
    name_ = name;
    start_ = clock_.Now();
    if (quiet_) return;
    std::printf("[%d/%d] %s\n", static_cast<int>(done_.size()) + 1, kSteps,
                name.c_str());
    std::fflush(stdout);  // progress goes to standard error
  }
  void End(const std::string& result) {
    const double seconds =
        base::MillisecondsBetween(start_, clock_.Now()) / 1e3;
    done_.push_back({name_, result, seconds});
    if (quiet_) return;
    std::printf("      %s (%.1f s)\n", result.c_str(), seconds);
    std::fflush(stdout);
  }
  const std::vector<learning::LearnStep>& done() const { return done_; }

 private:
  const bool quiet_;
  const base::SteadyClock clock_;
  base::MonotonicTime start_;
  std::string name_;
  std::vector<learning::LearnStep> done_;
};

std::string StemsOf(const Dataset& dataset, dataset::FrameUse use) {
  std::string list;
  for (int i = 0; i < dataset.size(); ++i) {
    if (dataset::UseOfFrame(i, dataset.size()) == use) {
      absl::StrAppend(&list, dataset.frame(i).stem, "\n");
    }
  }
  return list;
}

class PlaceLearner {
 public:
  PlaceLearner(const LearnOptions& options, learning::LearnSource source,
               OutputFolder output, std::stop_token stop)
      : options_(options),
        source_(std::move(source)),
        output_(std::move(output)),
        stop_(std::move(stop)),
        steps_(options.quiet) {}

  absl::Status Run() {
    page_.scene = options_.scene;
    page_.source = options_.source;
    TL_RETURN_IF_ERROR(Open());
    TL_RETURN_IF_ERROR(Calibrate());
    TL_RETURN_IF_ERROR(TrainOnPart());
    TL_RETURN_IF_ERROR(Test());
    TL_RETURN_IF_ERROR(TrainOnAll());
    TL_RETURN_IF_ERROR(PredictCoverage());
    return Publish();
  }

 private:
  // Makes a recording where there is none yet, and frame lists.
  absl::Status Open() {
    all_ = options_.dataset;
    all_.uri = source_.uri;
    steps_.Begin(source_.kind == SourceKind::kCapture ? "Import" : "Open");
    std::string imported;
    if (source_.kind == SourceKind::kCapture) {
      TL_ASSIGN_OR_RETURN(
          ImportedCapture capture,
          ImportCapture(options_.source, options_.capture,
                        output_.Path("recording"), options_.quiet, stop_));
      all_.uri = capture.uri;
      source_.train_list = capture.train_list;
      source_.test_list = capture.test_list;
      page_.notes = std::move(capture.notes);
      imported = capture.what;
    }
    if (source_.kind == SourceKind::kMapBundle) {
      TL_RETURN_IF_ERROR(TakeBundleCameras());
    }
    TL_ASSIGN_OR_RETURN(const Dataset dataset, Dataset::Open(all_));
    method_ = options_.method;
    if (method_.empty()) {
      method_ = dataset.structure() != nullptr ? "sift" : "universal";
    }
    TL_RETURN_IF_ERROR(
        learning::CheckLearnable(dataset, method_, options_.source));
    if (dataset.size() < kFewestFrames) {
      return absl::FailedPreconditionError(absl::StrFormat(
          "%s: %d frames are too few to learn a place from and to test it: "
          "record at least %d, better some hundred",
          options_.source, dataset.size(), kFewestFrames));
    }
    TL_RETURN_IF_ERROR(ChooseFrames(dataset));
    const std::string left_out = learning::LeftOutText(dataset, method_);
    if (!left_out.empty()) page_.notes.push_back("left out: " + left_out);
    steps_.End(absl::StrFormat(
        "%d frames%s: %d to learn, %d held out for the test%s%s",
        dataset.size(), imported, part_size_, held_out_->size(),
        left_out.empty() ? "" : "; left out: ", left_out));
    return absl::OkStatus();
  }

  absl::Status TakeBundleCameras() {
    TL_ASSIGN_OR_RETURN(calibration_,
                        tools::ReadCalibrationFile(source_.calibration_path));
    all_.color_camera = calibration_->color.ToString();
    all_.depth_camera = calibration_->depth.ToString();
    return absl::OkStatus();
  }

  // The recording's own lists, or blocks of frames; --frames is all there is.
  absl::Status ChooseFrames(const Dataset& dataset) {
    part_ = all_;
    DatasetOptions tested = all_;
    if (!all_.frame_list.empty() || source_.train_list.empty()) {
      part_.frame_list = output_.Path("train.txt");
      tested.frame_list = output_.Path("test.txt");
      TL_RETURN_IF_ERROR(base::WriteNewFile(
          part_.frame_list, StemsOf(dataset, dataset::FrameUse::kTrain)));
      TL_RETURN_IF_ERROR(base::WriteNewFile(
          tested.frame_list, StemsOf(dataset, dataset::FrameUse::kTest)));
    } else {
      part_.frame_list = source_.train_list;
      tested.frame_list = source_.test_list;
    }
    TL_ASSIGN_OR_RETURN(held_out_, Dataset::Open(tested));
    TL_ASSIGN_OR_RETURN(const Dataset part, Dataset::Open(part_));
    part_size_ = part.size();
    return absl::OkStatus();
  }

  // Else those that are usual in the recording's format are taken.
  bool StatesCameras() const {
    return source_.kind != SourceKind::kRecording || source_.has_cameras ||
           !all_.color_camera.empty() || method_ == "sift" ||
           (options_.calibration != "auto" &&
            options_.calibration != "nominal") ||
           absl::StartsWith(all_.uri, "12scenes:");
  }

  // What an import wrote has the phone's own calibration.
  absl::Status Calibrate() {
    steps_.Begin("Calibrate");
    TL_ASSIGN_OR_RETURN(const Dataset dataset, Dataset::Open(part_));
    const camera::RgbdSensor pose_sensor = dataset.calibration().pose_sensor;
    std::string result;
    if (method_ == "sift") {
      result = "no depth: the cameras are those of the structure";
    } else if (options_.calibration != "auto" &&
               options_.calibration != "nominal") {
      TL_ASSIGN_OR_RETURN(calibration_,
                          tools::ReadCalibrationFile(options_.calibration));
      result = "as given: " + options_.calibration;
    } else if (calibration_) {
      result = "the map's own";
    } else if (source_.kind == SourceKind::kCapture || source_.has_cameras ||
               options_.calibration == "nominal") {
      TL_RETURN_IF_ERROR(
          training::CheckPoses(dataset, {.threads = options_.training.threads},
                               options_.quiet, stop_));
      calibration_ = dataset.calibration();
      result = StatesCameras() ? "the recording's own cameras"
                               : "the usual cameras of such recordings";
    } else {
      training::CalibratorOptions calibrator;
      calibrator.threads = options_.training.threads;
      TL_ASSIGN_OR_RETURN(
          const training::CalibrationReport report,
          training::CalibrateRgbd(dataset, calibrator, options_.quiet, stop_));
      calibration_ = report.calibration;
      result = absl::StrFormat(
          "estimated from %d frames: surfaces agree to %.1f mm (before: %.1f)",
          report.frames, 1e3 * report.surface_rms_after_m,
          1e3 * report.surface_rms_before_m);
    }
    if (calibration_) calibration_->pose_sensor = pose_sensor;
    if (!StatesCameras()) {
      const std::string cameras = absl::StrCat(
          "the recording does not say what cameras it is of; taken for the ",
          "usual ones of its format: colour ",
          dataset.calibration().color.ToString(),
          ". Another camera: --color-camera, --depth-camera");
      page_.notes.push_back(cameras);
      absl::StrAppend(&result, "\n      note: ", cameras);
    }
    steps_.End(result);
    return absl::OkStatus();
  }

  absl::StatusOr<forest::ModelInfo> Train(const DatasetOptions& dataset_options,
                                          const std::string& path) {
    TL_ASSIGN_OR_RETURN(const Dataset dataset, Dataset::Open(dataset_options));
    training::SceneTrainingOptions training;
    training.method = method_;
    training.calibration = calibration_;
    training.forest = options_.training;
    training.software_version = base::Version();
    training.created_utc = tools::UtcNow();
    training.recorded_options =
        method_ == "sift"
            ? tools::RecordedSiftOptions(dataset_options, options_.training,
                                         training.sift)
            : tools::RecordedOptions(dataset_options, options_.calibration,
                                     options_.training);
    TL_ASSIGN_OR_RETURN(
        const training::TrainedScene scene,
        training::TrainScene(dataset, training, path, options_.quiet, stop_));
    return scene.info;
  }

  absl::Status TrainOnPart() {
    steps_.Begin("Train");
    TL_ASSIGN_OR_RETURN(const forest::ModelInfo info, Train(part_, model()));
    page_.units_are_metres = info.units_are_metres;
    steps_.End(absl::StrFormat("method %s, %d trees, %s", info.method,
                               info.trees,
                               tools::FormatBytes(info.file_bytes)));
    return absl::OkStatus();
  }

  absl::Status Test() {
    steps_.Begin("Test");
    TL_ASSIGN_OR_RETURN(
        HeldOutEvaluation evaluation,
        EvaluateHeldOut(model(), *held_out_, all_, options_.training.seed,
                        options_.quiet, stop_));
    page_.right_within = evaluation.right_within;
    page_.trials = evaluation.trials;
    page_.foreign_pictures = evaluation.foreign_pictures;
    page_.foreign_answered = evaluation.foreign_answered;
    page_.missed = evaluation.missed;
    page_.missed_pictures = std::move(evaluation.pictures);
    missed_world_from_camera_ = std::move(evaluation.missed_world_from_camera);
    std::string result;
    for (const learning::HeldOutTrial& t : page_.trials) {
      absl::StrAppendFormat(&result, "%s%s: %d of %d right",
                            result.empty() ? "" : "; ", t.queries, t.right,
                            t.frames);
    }
    steps_.End(result);
    return absl::OkStatus();
  }

  absl::Status TrainOnAll() {
    steps_.Begin("Learn all");
    if (options_.only_tested) {
      steps_.End("left out: the model that was tested is published");
      return absl::OkStatus();
    }
    TL_ASSIGN_OR_RETURN(const forest::ModelInfo info, Train(all_, model()));
    steps_.End(absl::StrFormat("from %d frames, held-out ones too: %s",
                               info.training_frames,
                               tools::FormatBytes(info.file_bytes)));
    return absl::OkStatus();
  }

  absl::Status PredictCoverage() {
    steps_.Begin("Coverage");
    TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> file,
                        forest::ModelFile::Open(model()));
    TL_ASSIGN_OR_RETURN(const keyframes::KeyframeMap map,
                        keyframes::KeyframeMap::Read(*file));
    const absl::StatusOr<keyframes::CoverageMap> coverage =
        keyframes::PredictCoverage(map, file->info().calibration.color, {});
    if (stop_.stop_requested()) return absl::CancelledError("interrupted");
    if (!coverage.ok()) {
      page_.no_coverage_because =
          absl::StrCat("It cannot be predicted for this model: ",
                       std::string(coverage.status().message()), ".");
      steps_.End("not predicted for method " + method_);
      return absl::OkStatus();
    }
    learning::PageCoverage shown{
        .summary = keyframes::Summarize(*coverage),
        .png = {},
        .weak_spots = learning::FindWeakSpots(*coverage, kWeakSpots)};
    TL_ASSIGN_OR_RETURN(
        shown.png, image::EncodePng(tools::DrawCoverage(
                       map, *coverage,
                       absl::StrCat("Where ", options_.scene, " will work"),
                       Marks(*coverage, shown.weak_spots))));
    TL_RETURN_IF_ERROR(
        base::WriteNewFile(output_.Path("coverage.png"), shown.png));
    steps_.End(absl::StrFormat("%.0f %% of the views from %.1f square metres",
                               100 * shown.summary.good_share,
                               shown.summary.open_m2));
    page_.coverage = std::move(shown);
    return absl::OkStatus();
  }

  tools::CoverageMarks Marks(
      const keyframes::CoverageMap& coverage,
      const std::vector<learning::WeakSpot>& weak_spots) const {
    tools::CoverageMarks marks;
    for (const learning::WeakSpot& spot : weak_spots) {
      marks.letters.push_back(
          {.text =
               std::string(1, static_cast<char>('A' + marks.letters.size())),
           .x_m = spot.x_m,
           .y_m = spot.y_m,
           .towards_rad = spot.towards_rad});
    }
    const geometry::Mat3 plan_from_world = coverage.plan_from_world.Matrix();
    for (const geometry::Rigid3& pose : missed_world_from_camera_) {
      const geometry::Vec3 at = plan_from_world * pose.translation;
      marks.crosses.push_back({.x_m = at.x, .y_m = at.y});
    }
    return marks;
  }

  // The page first: a model without its page is less than a page without.
  absl::Status Publish() {
    steps_.Begin("Publish");
    TL_ASSIGN_OR_RETURN(
        const std::string published,
        tools::NextModelPath(options_.repository, options_.scene));
    const absl::Status status = PublishAt(published);
    if (!status.ok()) tools::RemoveEmptyVersion(published);
    TL_RETURN_IF_ERROR(status);
    output_.Keep();
    steps_.End(published);
    if (!options_.quiet) {
      std::printf("%s\nThe page: %s\n",
                  learning::Judge(page_.trials, page_.units_are_metres)
                      .headline.c_str(),
                  output_.Path(kPage).c_str());
    }
    return absl::OkStatus();
  }

  absl::Status PublishAt(const std::string& published) {
    page_.steps = steps_.done();
    page_.made_utc = tools::UtcNow();
    page_.software = absl::StrCat("treeline ", base::Version());
    page_.commands = Commands(published);
    TL_RETURN_IF_ERROR(base::WriteNewFile(output_.Path(kPage),
                                          learning::LearnPageHtml(page_)));
    if (stop_.stop_requested()) return absl::CancelledError("interrupted");
    TL_ASSIGN_OR_RETURN(const std::string bytes,
                        base::ReadFile(model(), kMaxModelBytes));
    TL_RETURN_IF_ERROR(base::WriteFileAtomically(published, bytes));
    std::error_code ignored;
    std::filesystem::remove(model(), ignored);
    return absl::OkStatus();
  }

  std::vector<std::pair<std::string, std::string>> Commands(
      const std::string& published) const {
    const std::string extended = absl::StrCat(
        "treeline import CAPTURE --output more\ntreeline train --extend ",
        tools::ShellQuoted(published),
        " \\\n    --dataset 7scenes:more --repository ",
        tools::ShellQuoted(options_.repository), " --scene ",
        tools::ShellQuoted(options_.scene));
    std::vector<std::pair<std::string, std::string>> commands = {
        {"Serve it; a server that runs on this repository with --poll-s takes "
         "it by itself:",
         "treeline-server --models " +
             tools::ShellQuoted(options_.repository)}};
    if (method_ != "sift") {
      commands.emplace_back(
          "Add a recording that is in the same world (of the same session of "
          "the app, or aligned with it):",
          extended);
    }
    commands.emplace_back(
        "All figures, frame by frame (of the published model; it has learnt "
        "the held-out frames unless --only-tested was given):",
        absl::StrCat("treeline evaluate --model ",
                     tools::ShellQuoted(published), " \\\n    --dataset ",
                     tools::ShellQuoted(all_.uri), " --report report.html"));
    return commands;
  }

  std::string model() const { return output_.Path("model.treeline"); }

  const LearnOptions& options_;
  learning::LearnSource source_;
  OutputFolder output_;
  const std::stop_token stop_;
  Steps steps_;
  std::string method_;
  DatasetOptions all_;
  DatasetOptions part_;
  int part_size_ = 0;
  std::optional<Dataset> held_out_;
  std::optional<camera::RgbdCalibration> calibration_;
  std::vector<geometry::Rigid3> missed_world_from_camera_;
  learning::LearnPage page_;
};

}  // namespace

absl::Status LearnPlace(const LearnOptions& given,
                        const std::stop_token& stop) {
  LearnOptions options = given;
  TL_ASSIGN_OR_RETURN(learning::LearnSource source,
                      learning::FindLearnSource(options.source));
  if (options.scene.empty()) {
    options.scene = source.scene.empty() ? learning::SceneNameOf(options.source)
                                         : source.scene;
  }
  TL_RETURN_IF_ERROR(repository::CheckName("--scene", options.scene));
  if (options.output.empty()) options.output = options.scene + "-learnt";
  TL_RETURN_IF_ERROR(tools::CheckFolderCanBeMade(options.repository));
  TL_ASSIGN_OR_RETURN(OutputFolder output,
                      OutputFolder::Create(options.output));
  return PlaceLearner(options, std::move(source), std::move(output), stop)
      .Run();
}

}  // namespace treeline::tools_app
