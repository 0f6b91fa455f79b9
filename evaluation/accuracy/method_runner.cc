#include "evaluation/accuracy/method_runner.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/camera/calibration_json.h"
#include "evaluation/accuracy/query_calibration.h"
#include "server/core/forest/model_file.h"
#include "server/tools/run_info.h"

namespace treeline::accuracy {
namespace {

// Pictures of each method in a comparison: the page shows many methods.
constexpr int kComparedWorst = 3;
constexpr int kComparedOthers = 1;
// Pixels that a heat map's query samples: as many as a query may.
constexpr int kHeatMapSamples = 20000;
constexpr int kHeatMaps = 3;

absl::StatusOr<camera::RgbdCalibration> ReadCalibration(
    const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string json, base::ReadFile(path, 1 << 20));
  absl::StatusOr<camera::RgbdCalibration> calibration =
      camera::CalibrationFromJson(json);
  if (!calibration.ok()) return base::Annotate(calibration.status(), path);
  return calibration;
}

// Evenly spread over the list: the same ones for every method.
std::vector<int> HeatMapFrames(int frames) {
  std::vector<int> chosen;
  for (int k = 0; k < kHeatMaps; ++k) {
    const int frame = (2 * k + 1) * frames / (2 * kHeatMaps);
    if (chosen.empty() || chosen.back() != frame) chosen.push_back(frame);
  }
  return chosen;
}

// Up to `count` frames, evenly spread over the recording; 0: all.
dataset::Dataset EvenlySpread(const dataset::Dataset& dataset, int count) {
  if (count == 0 || count >= dataset.size()) return dataset;
  std::vector<int> frames;
  for (int64_t k = 0; k < count; ++k) {
    frames.push_back(static_cast<int>(k * dataset.size() / count));
  }
  return dataset.Subset(frames);
}

bool IsInterrupted(const absl::Status& status) {
  return status.code() == absl::StatusCode::kCancelled;
}

}  // namespace

absl::StatusOr<MethodRunner> MethodRunner::Open(const EvaluateFlags& flags,
                                                const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(dataset::Dataset dataset,
                      dataset::Dataset::Open(flags.dataset));
  if (const auto& missing = dataset.missing_pictures(); missing.count > 0) {
    std::fprintf(stderr, "not asked: %d %s of %s (the first: %s)\n",
                 missing.count,
                 missing.count == 1 ? "image whose picture is not there"
                                    : "images whose pictures are not there",
                 dataset.uri().c_str(), missing.first.c_str());
  }
  std::optional<camera::RgbdCalibration> calibration;
  if (!flags.calibration_path.empty()) {
    TL_ASSIGN_OR_RETURN(calibration, ReadCalibration(flags.calibration_path));
  }
  dataset::DatasetOptions training_options = flags.training;
  training_options.color_camera = flags.dataset.color_camera;
  training_options.depth_camera = flags.dataset.depth_camera;
  training_options.depth_unit_m = flags.dataset.depth_unit_m;
  training_options.max_time_difference_s = flags.dataset.max_time_difference_s;
  std::optional<dataset::Dataset> training;
  if (!flags.training.uri.empty()) {
    TL_ASSIGN_OR_RETURN(training, dataset::Dataset::Open(training_options));
  }
  // Better now than when the work is done.
  for (const NegativeSource& source : flags.foreign) {
    if (source.builtin) continue;
    TL_RETURN_IF_ERROR(dataset::Dataset::Open(source.dataset).status());
  }
  tools::ModelStoreOptions store_options{
      .dataset = training_options,
      .calibration_name =
          calibration ? flags.calibration_path : std::string("auto"),
      .calibration = calibration,
      .quiet = flags.quiet,
      .stop = stop};
  TL_ASSIGN_OR_RETURN(
      tools::ModelStore store,
      tools::ModelStore::Open(flags.models_folder, std::move(store_options)));
  return MethodRunner(flags, stop, std::move(dataset), std::move(training),
                      std::move(calibration), std::move(store));
}

MethodRunner::MethodRunner(const EvaluateFlags& flags, std::stop_token stop,
                           dataset::Dataset dataset,
                           std::optional<dataset::Dataset> training,
                           std::optional<camera::RgbdCalibration> calibration,
                           tools::ModelStore store)
    : flags_(flags),
      stop_(std::move(stop)),
      dataset_(std::move(dataset)),
      training_(std::move(training)),
      calibration_(std::move(calibration)),
      store_(std::move(store)) {}

absl::StatusOr<std::vector<EvaluatedMethod>> MethodRunner::EvaluateMethods() {
  std::vector<EvaluatedMethod> methods(flags_.methods.size());
  // Baselines last: they profit from the calibration of a trained model.
  for (const bool baselines : {false, true}) {
    for (size_t i = 0; i < methods.size(); ++i) {
      const MethodSpec& spec = flags_.methods[i];
      if (spec.baseline.has_value() != baselines) continue;
      methods[i].name = spec.name;
      if (flags_.comparing() && !flags_.quiet) {
        std::fprintf(stderr, "%s\n", spec.name.c_str());
      }
      methods[i].status = Evaluate(spec, methods[i]);
      if (IsInterrupted(methods[i].status)) return methods[i].status;
    }
  }
  return methods;
}

absl::Status MethodRunner::Evaluate(const MethodSpec& spec,
                                    EvaluatedMethod& method) {
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<localizer::Localizer> localizer,
                      Build(spec, method));
  method.model = localizer->info();
  method.training_poses = TrainingPoses(method.model);
  if (method.name.empty()) method.name = method.model.method;
  TL_ASSIGN_OR_RETURN(const EvaluationOptions options,
                      Options(spec, method.model));
  tools::ResetPeakMemory();
  TL_ASSIGN_OR_RETURN(method.results,
                      treeline::accuracy::Evaluate(
                          *localizer, dataset_, options, base::SteadyClock()));
  method.peak_memory_bytes = tools::PeakMemoryBytes();
  TL_RETURN_IF_ERROR(AddPerturbed(*localizer, options, method));
  return AddDetails(*localizer, spec, options, method);
}

absl::StatusOr<std::string> MethodRunner::ModelPath(
    const MethodSpec& spec) const {
  if (!spec.NeedsTraining()) return spec.model_path;
  return store_.Train(*training_, spec.trained_method, TrainingFor(spec, {}));
}

absl::StatusOr<std::unique_ptr<localizer::Localizer>> MethodRunner::Build(
    const MethodSpec& spec, EvaluatedMethod& method) {
  if (!spec.baseline) {
    TL_ASSIGN_OR_RETURN(method.model_path, ModelPath(spec));
    absl::StatusOr<std::unique_ptr<localizer::Localizer>> localizer =
        localizer::OpenLocalizer(method.model_path,
                                 QueriesFor(spec, flags_.query));
    if (localizer.ok() && !estimated_calibration_) {
      estimated_calibration_ = (*localizer)->info().calibration;
    }
    return localizer;
  }
  camera::RgbdCalibration calibration = training_->calibration();
  if (estimated_calibration_) calibration = *estimated_calibration_;
  if (!flags_.model_path.empty()) {
    TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> model,
                        forest::ModelFile::Open(flags_.model_path));
    calibration = model->info().calibration;
  }
  if (calibration_) calibration = *calibration_;
  FeaturePnpOptions options = flags_.features;
  options.structure_features = flags_.query.features;
  options.kind = *spec.baseline;
  options.seed = flags_.seed;
  options.quiet = flags_.quiet;
  options.stop = stop_;
  return BuildFeaturePnpBaseline(*training_, calibration, options);
}

absl::StatusOr<EvaluationOptions> MethodRunner::Options(
    const MethodSpec& spec, const forest::ModelInfo& info) const {
  EvaluationOptions options;
  options.seed = flags_.seed;
  options.min_confidence = flags_.min_confidence;
  options.threads = flags_.threads;
  options.quiet = flags_.quiet;
  options.stop = stop_;
  options.calibration =
      QueryCalibration(dataset_, flags_.dataset, info.calibration);
  if (calibration_ && !spec.baseline) options.calibration = calibration_;
  TellCameras(options.calibration, info.calibration);
  TL_RETURN_IF_ERROR(options.Validate());
  return options;
}

void MethodRunner::TellCameras(
    const std::optional<camera::RgbdCalibration>& query,
    const camera::RgbdCalibration& scene) const {
  const bool is_named = !flags_.dataset.color_camera.empty() ||
                        !flags_.dataset.depth_camera.empty() || calibration_;
  if (!is_named) return;
  std::fprintf(stderr, "queries are taken with the colour camera %s, %s\n",
               (query ? *query : scene).color.ToString().c_str(),
               query ? "as given"
                     : "the model's, refined in training from one like that "
                       "given (--calibration FILE overrules it)");
}

absl::Status MethodRunner::AddPerturbed(const localizer::Localizer& localizer,
                                        EvaluationOptions options,
                                        EvaluatedMethod& method) const {
  if (flags_.perturbations.empty()) return absl::OkStatus();
  const dataset::Dataset frames =
      EvenlySpread(dataset_, flags_.perturbed_frames);
  std::vector<Perturbation> perturbations{Perturbation{}};
  perturbations.insert(perturbations.end(), flags_.perturbations.begin(),
                       flags_.perturbations.end());
  for (const Perturbation& perturbation : perturbations) {
    if (!flags_.quiet) {
      std::fprintf(stderr, "%s\n", perturbation.Name().c_str());
    }
    options.perturbation = perturbation;
    TL_ASSIGN_OR_RETURN(std::vector<FrameResult> results,
                        treeline::accuracy::Evaluate(localizer, frames, options,
                                                     base::SteadyClock()));
    method.perturbed.push_back({perturbation, std::move(results)});
  }
  return absl::OkStatus();
}

absl::Status MethodRunner::AddDetails(const localizer::Localizer& localizer,
                                      const MethodSpec& spec,
                                      const EvaluationOptions& options,
                                      EvaluatedMethod& method) const {
  TL_ASSIGN_OR_RETURN(method.foreign,
                      AskForeign(localizer, flags_.foreign,
                                 flags_.confidence_threshold, options));
  if (flags_.report_path.empty() && flags_.json_path.empty()) {
    return absl::OkStatus();
  }
  TL_ASSIGN_OR_RETURN(
      method.scene_errors_m,
      SceneCoordinateErrors(localizer, dataset_, kSceneErrorFrames, options));
  if (flags_.report_path.empty()) return absl::OkStatus();
  method.pictures = TakePictures(
      localizer, dataset_,
      flags_.comparing() ? ChoosePictures(method.results, kComparedWorst,
                                          kComparedOthers, kComparedOthers)
                         : ChoosePictures(method.results),
      options);
  if (!method.model_path.empty()) {
    TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> model,
                        forest::ModelFile::Open(method.model_path));
    method.splits = SplitRatios(model->forest());
    localizer::QueryOptions dense = QueriesFor(spec, flags_.query);
    dense.samples = kHeatMapSamples;
    dense.first_samples = kHeatMapSamples;
    TL_ASSIGN_OR_RETURN(
        const std::unique_ptr<localizer::Localizer> dense_localizer,
        localizer::OpenLocalizer(method.model_path, dense));
    method.heat_maps = TakeHeatMaps(*dense_localizer, dataset_,
                                    HeatMapFrames(dataset_.size()), options);
  }
  if (stop_.stop_requested()) {
    return absl::CancelledError("evaluation was interrupted");
  }
  return absl::OkStatus();
}

// Of the model's pose sensor; empty if not known. What the model says it was
// trained on is a convenience for the report, and its absence no error.
std::vector<geometry::Rigid3> MethodRunner::TrainingPoses(
    const forest::ModelInfo& info) const {
  std::optional<dataset::Dataset> recorded;
  if (!training_) {
    dataset::DatasetOptions options;
    options.uri = info.dataset;
    for (const auto& [name, value] : info.options) {
      if (name == "frames") options.frame_list = value;
      if (name == "poses") options.pose_file = value;
    }
    absl::StatusOr<dataset::Dataset> opened = dataset::Dataset::Open(options);
    if (opened.ok()) recorded = *std::move(opened);
  }
  const std::optional<dataset::Dataset>& training =
      training_ ? training_ : recorded;
  std::vector<geometry::Rigid3> poses;
  for (int i = 0; training && i < training->size(); ++i) {
    const dataset::DatasetFrame& frame = training->frame(i);
    if (!frame.world_from_camera) continue;
    poses.push_back(camera::PoseOfSensor(
        *frame.world_from_camera, training->calibration().pose_sensor,
        info.calibration.pose_sensor, info.calibration));
  }
  return poses;
}

absl::StatusOr<std::vector<Sweep>> MethodRunner::RunSweeps(
    const std::vector<EvaluatedMethod>& evaluated,
    std::vector<std::string>& problems) {
  std::vector<Sweep> sweeps;
  for (const SweepRequest& request : flags_.sweeps) {
    Sweep sweep{.variable = request.variable, .lines = {}};
    for (const MethodSpec& spec : flags_.sweep_methods) {
      const auto index = static_cast<size_t>(
          std::ranges::find(flags_.methods, spec.name, &MethodSpec::name) -
          flags_.methods.begin());
      SweepLine line{.method = evaluated[index].name, .points = {}};
      const absl::Status status =
          RunLine(spec, request, evaluated[index], line);
      if (IsInterrupted(status)) return status;
      if (!status.ok()) {
        problems.push_back(absl::StrCat("sweep of ", SweepName(sweep.variable),
                                        ", ", line.method, ": ",
                                        std::string(status.message())));
      }
      if (!line.points.empty()) sweep.lines.push_back(std::move(line));
    }
    if (!sweep.lines.empty()) sweeps.push_back(std::move(sweep));
  }
  return sweeps;
}

absl::Status MethodRunner::RunLine(const MethodSpec& spec,
                                   const SweepRequest& request,
                                   const EvaluatedMethod& evaluated,
                                   SweepLine& line) const {
  TL_RETURN_IF_ERROR(evaluated.status);
  std::string base_model = evaluated.model_path;
  if (request.variable == SweepVariable::kTrees && spec.NeedsTraining()) {
    // One forest of the most trees, which is then cut.
    training::TrainingOptions training = TrainingFor(spec, {});
    training.trees = std::max(training.trees, request.values.back());
    TL_ASSIGN_OR_RETURN(
        base_model, store_.Train(*training_, spec.trained_method, training));
  }
  for (int value : request.values) {
    if (!flags_.quiet) {
      std::fprintf(stderr, "%s, %s %d\n", line.method.c_str(),
                   SweepName(request.variable), value);
    }
    TL_ASSIGN_OR_RETURN(SweepPoint point,
                        RunPoint(spec, request, value, base_model));
    line.points.push_back(std::move(point));
  }
  return absl::OkStatus();
}

absl::StatusOr<SweepPoint> MethodRunner::RunPoint(
    const MethodSpec& spec, const SweepRequest& request, int value,
    const std::string& base_model) const {
  localizer::QueryOptions query = QueriesFor(spec, flags_.query);
  std::string model_path = base_model;
  SetQueryOption(request.variable, value, query);
  if (request.variable == SweepVariable::kTrees) {
    model_path = store_.PathOf(absl::StrCat("first-trees-", value));
    TL_RETURN_IF_ERROR(WriteFirstTrees(base_model, value, model_path));
  } else if (request.variable == SweepVariable::kBalancedLevels) {
    TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> model,
                        forest::ModelFile::Open(base_model));
    training::TrainingOptions training = TrainingFor(spec, {});
    training.balanced_levels = value;
    TL_ASSIGN_OR_RETURN(
        model_path, store_.Train(*training_, model->info().method, training));
  }
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<localizer::Localizer> localizer,
                      localizer::OpenLocalizer(model_path, query));
  const forest::ModelInfo info = localizer->info();
  TL_ASSIGN_OR_RETURN(const EvaluationOptions options, Options(spec, info));
  TL_ASSIGN_OR_RETURN(const std::vector<FrameResult> results,
                      treeline::accuracy::Evaluate(
                          *localizer, dataset_, options, base::SteadyClock()));
  if (request.variable == SweepVariable::kTrees) {
    std::remove(model_path.c_str());
  }
  return SweepPoint{.value = value,
                    .summary = Summarize(results),
                    .training_s = info.training_s,
                    .model_bytes = info.file_bytes};
}

}  // namespace treeline::accuracy
