#include "server/core/training/scene_trainer.h"

#include <algorithm>
#include <memory>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/core/forest/model_file.h"
#include "server/core/training/forest_trainer.h"

namespace treeline {
namespace {

constexpr MethodDescription kMethods[] = {
    {"rgbd",
     "colour and depth, in training and in queries: a backtracking regression "
     "forest on depth-adaptive colour differences"},
    {"rgb",
     "colour and depth in training, colour alone in queries: a backtracking "
     "regression forest on colour differences, and PnP"},
    {"sift",
     "colour alone, with a structure from motion (colmap:, nvm:): a "
     "backtracking regression forest on SIFT features, and PnP"},
};

bool IsKnown(absl::string_view method) {
  return std::ranges::any_of(
      kMethods, [&](const MethodDescription& m) { return m.name == method; });
}

// What the methods learn apart from each other.
absl::StatusOr<Forest> LearnSift(const Dataset& dataset,
                                 const SceneTrainingOptions& options,
                                 bool quiet, const std::stop_token& stop,
                                 TrainedScene& scene) {
  SiftTrainingOptions sift = options.sift;
  sift.seed = options.forest.seed;
  sift.threads = options.forest.threads;
  sift.trees = options.forest.trees;
  TL_ASSIGN_OR_RETURN(TrainedSiftForest trained,
                      TrainSiftForest(dataset, sift, quiet, stop));
  ModelInfo& info = scene.info;
  info.calibration = dataset.calibration();
  info.units_are_metres = dataset.units_are_metres();
  info.viewing_distance = trained.viewing_distance;
  info.training_frames = trained.images;
  info.training_samples = trained.samples;
  return std::move(trained.forest);
}

absl::StatusOr<Forest> LearnPixelForest(const Dataset& dataset,
                                        const SceneTrainingOptions& options,
                                        bool quiet, const std::stop_token& stop,
                                        TrainedScene& scene) {
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
  TrainingOptions forest = options.forest;
  forest.depth_adaptive = options.method != "rgb";
  TL_ASSIGN_OR_RETURN(
      TrainedForest trained,
      TrainForest(dataset, info.calibration, forest, quiet, stop));
  // What sees colour alone answers with the colour camera's pose.
  if (options.method == "rgb") {
    info.calibration.pose_sensor = RgbdSensor::kColor;
  }
  info.training_frames = trained.frames;
  info.training_samples = trained.samples;
  return std::move(trained.forest);
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
  TL_ASSIGN_OR_RETURN(
      const Forest forest,
      options.method == "sift"
          ? LearnSift(dataset, options, quiet, stop, scene)
          : LearnPixelForest(dataset, options, quiet, stop, scene));
  info.method = options.method;
  info.software_version = options.software_version;
  info.created_utc = options.created_utc;
  info.dataset = dataset.uri();
  info.seed = options.forest.seed;
  info.options = options.recorded_options;
  info.training_s = MillisecondsBetween(start, clock.Now()) / 1e3;
  TL_RETURN_IF_ERROR(WriteModel(output_path, info, {forest.View()}));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<const ModelFile> model,
                      ModelFile::Open(output_path));
  info = model->info();
  return scene;
}

}  // namespace treeline
