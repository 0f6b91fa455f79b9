#include "server/core/training/scene_trainer.h"

#include <algorithm>
#include <memory>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/core/forest/model_file.h"
#include "server/core/training/forest_trainer.h"
#include "server/core/training/keyframe_builder.h"

namespace treeline {
namespace {

constexpr MethodDescription kMethods[] = {
    {"rgbd",
     "colour and depth, in training and in queries: a backtracking regression "
     "forest on depth-adaptive colour differences"},
    {"rgb",
     "colour and depth in training, colour alone in queries: a backtracking "
     "regression forest on colour differences, and PnP"},
    {"points-lines",
     "like rgbd, with a second forest for points on line segments, which hold "
     "the pose across their lines"},
};

bool IsKnown(absl::string_view method) {
  return std::ranges::any_of(
      kMethods, [&](const MethodDescription& m) { return m.name == method; });
}

// points-lines: leaves have modes with this bandwidth (m).
constexpr double kModeBandwidth_m = 0.05;

// Forest 0 on all pixels and, for points-lines, forest 1 on those of line
// segments (thesis 5.4). Sets what `info` says of the training data.
absl::StatusOr<std::vector<Forest>> LearnPixelForests(
    const Dataset& dataset, const SceneTrainingOptions& options, bool quiet,
    const std::stop_token& stop, ModelInfo& info) {
  TrainingOptions forest = options.forest;
  forest.depth_adaptive = options.method != "rgb";
  const bool lines = options.method == "points-lines";
  if (lines) {
    forest.objective = SplitObjective::kEntropy;
    forest.mode_bandwidth_m = kModeBandwidth_m;
  }
  std::vector<Forest> forests;
  for (const bool line_points : {false, true}) {
    if (line_points && !lines) break;
    forest.line_points = line_points;
    TL_ASSIGN_OR_RETURN(
        TrainedForest trained,
        TrainForest(dataset, info.calibration, forest, quiet, stop));
    info.training_frames = trained.frames;
    info.training_samples += trained.samples;
    forests.push_back(std::move(trained.forest));
  }
  return forests;
}

template <typename T>
absl::string_view BytesOf(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()),
          values.size() * sizeof(T)};
}

}  // namespace

std::span<const MethodDescription> TrainableMethods() { return kMethods; }

absl::StatusOr<TrainedScene> TrainScene(const Dataset& dataset,
                                        const SceneTrainingOptions& options,
                                        const std::string& output_path,
                                        bool quiet,
                                        const std::stop_token& stop) {
  if (!IsKnown(options.method)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "method \"", options.method, "\" is not known; see --help"));
  }
  TL_RETURN_IF_ERROR(options.forest.Validate());
  TL_RETURN_IF_ERROR(MakeParentFolder(output_path));
  TL_RETURN_IF_ERROR(CheckWritable(output_path));
  const SteadyClock clock;
  const MonotonicTime start = clock.Now();
  TrainedScene scene;
  ModelInfo& info = scene.info;
  if (options.calibration) {
    info.calibration = *options.calibration;
  } else {
    CalibratorOptions calibrator;
    calibrator.threads = options.forest.threads;
    TL_ASSIGN_OR_RETURN(scene.calibration,
                        CalibrateRgbd(dataset, calibrator, quiet, stop));
    info.calibration = scene.calibration->calibration;
  }
  TL_ASSIGN_OR_RETURN(const std::vector<Forest> forests,
                      LearnPixelForests(dataset, options, quiet, stop, info));
  KeyframeOptions keyframe_options;
  keyframe_options.threads = options.forest.threads;
  TL_ASSIGN_OR_RETURN(
      const Keyframes keyframes,
      BuildKeyframes(dataset, info.calibration, keyframe_options, quiet, stop));
  info.method = options.method;
  // What sees colour alone answers with the colour camera's pose.
  if (info.method == "rgb") info.calibration.pose_sensor = RgbdSensor::kColor;
  info.software_version = options.software_version;
  info.created_utc = options.created_utc;
  info.dataset = dataset.uri();
  info.seed = options.forest.seed;
  info.options = options.recorded_options;
  info.training_s = MillisecondsBetween(start, clock.Now()) / 1e3;
  const std::vector<ModelExtraBytes> extras = {
      {ModelExtra::kKeyframes, BytesOf(keyframes.records)},
      {ModelExtra::kKeyframePoints, BytesOf(keyframes.points)}};
  std::vector<ForestView> views;
  for (const Forest& forest : forests) views.push_back(forest.View());
  TL_RETURN_IF_ERROR(WriteModel(output_path, info, views, extras));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<const ModelFile> model,
                      ModelFile::Open(output_path));
  info = model->info();
  return scene;
}

}  // namespace treeline
