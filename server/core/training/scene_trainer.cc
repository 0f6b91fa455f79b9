#include "server/core/training/scene_trainer.h"

#include <algorithm>
#include <memory>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/core/forest/model_file.h"
#include "server/core/training/forest_trainer.h"
#include "server/core/training/sift_scene_trainer.h"

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
  if (options.method == "sift") {
    return TrainSiftScene(dataset, options, output_path, quiet, stop);
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
  TrainingOptions forest = options.forest;
  forest.depth_adaptive = options.method != "rgb";
  TL_ASSIGN_OR_RETURN(
      const TrainedForest trained,
      TrainForest(dataset, info.calibration, forest, quiet, stop));
  info.method = options.method;
  // What sees colour alone answers with the colour camera's pose.
  if (info.method == "rgb") info.calibration.pose_sensor = RgbdSensor::kColor;
  info.software_version = options.software_version;
  info.created_utc = options.created_utc;
  info.dataset = dataset.uri();
  info.seed = options.forest.seed;
  info.options = options.recorded_options;
  info.training_frames = trained.frames;
  info.training_samples = trained.samples;
  info.training_s = MillisecondsBetween(start, clock.Now()) / 1e3;
  TL_RETURN_IF_ERROR(WriteModel(output_path, info, {trained.forest.View()}));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<const ModelFile> model,
                      ModelFile::Open(output_path));
  info = model->info();
  return scene;
}

}  // namespace treeline
