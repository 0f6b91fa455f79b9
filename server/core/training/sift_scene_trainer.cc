#include "server/core/training/sift_scene_trainer.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/core/forest/model_file.h"
#include "server/core/training/appearance_builder.h"
#include "server/core/training/confidence_fitter.h"
#include "server/core/training/sift_trainer.h"

namespace treeline::training {
namespace {

// What confidence is the probability of: an error below this share of the
// viewing distance, and this angle.
constexpr double kRightPosition = 0.01;
constexpr double kRightRotation_rad = 0.017453292519943295;

std::vector<int> FramesWithPoses(const dataset::Dataset& dataset) {
  std::vector<int> frames;
  for (int i = 0; i < dataset.size(); ++i) {
    if (dataset.frame(i).world_from_camera) frames.push_back(i);
  }
  return frames;
}

}  // namespace

absl::StatusOr<TrainedScene> TrainSiftScene(const dataset::Dataset& dataset,
                                            const SceneTrainingOptions& options,
                                            const std::string& output_path,
                                            bool quiet,
                                            const std::stop_token& stop) {
  SiftTrainingOptions sift = options.sift;
  sift.seed = options.forest.seed;
  sift.threads = options.forest.threads;
  sift.trees = options.forest.trees;
  TL_RETURN_IF_ERROR(sift.Validate());
  TL_RETURN_IF_ERROR(base::MakeParentFolder(output_path));
  TL_RETURN_IF_ERROR(base::CheckWritable(output_path));
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  TrainedScene scene;
  forest::ModelInfo& info = scene.info;
  info.method = options.method;
  info.software_version = options.software_version;
  info.created_utc = options.created_utc;
  info.dataset = dataset.uri();
  info.seed = sift.seed;
  info.options = options.recorded_options;
  info.calibration = dataset.calibration();
  info.units_are_metres = dataset.units_are_metres();
  const HeldOutSplit split =
      SplitPhotographsForConfidence(FramesWithPoses(dataset));
  if (!split.held_out.empty()) {
    // Learn from a part and see how the rest is answered; then learn it all.
    TL_ASSIGN_OR_RETURN(
        const TrainedSiftForest part,
        TrainSiftForest(dataset.Subset(split.train), sift, quiet, stop));
    info.viewing_distance = part.viewing_distance;
    ConfidenceOptions confidence;
    confidence.seed = sift.seed;
    confidence.threads = sift.threads;
    confidence.translation_m = kRightPosition * part.viewing_distance;
    confidence.rotation_rad = kRightRotation_rad;
    confidence.prior = forest::ConfidenceModel::OfSiftMatches();
    TL_ASSIGN_OR_RETURN(
        info.confidence,
        LearnConfidence(
            [&](const std::string& path) {
              return forest::WriteModel(path, info, {part.forest.View()});
            },
            output_path, dataset.Subset(split.held_out), confidence, quiet,
            stop));
  }
  TL_ASSIGN_OR_RETURN(const TrainedSiftForest trained,
                      TrainSiftForest(dataset, sift, quiet, stop));
  info.viewing_distance = trained.viewing_distance;
  info.training_frames = trained.images;
  info.training_samples = trained.samples;
  info.training_s = base::MillisecondsBetween(start, clock.Now()) / 1e3;
  AppearanceOptions appearance;
  appearance.threads = sift.threads;
  TL_ASSIGN_OR_RETURN(const recognition::SceneDescriptor descriptor,
                      BuildSceneDescriptor(dataset, appearance, quiet, stop));
  const std::string bytes = descriptor.Serialize();
  const forest::ModelExtraBytes extra{forest::ModelExtra::kSceneDescriptor,
                                      bytes};
  TL_RETURN_IF_ERROR(forest::WriteModel(
      output_path, info, {trained.forest.View()}, std::span(&extra, 1)));
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> model,
                      forest::ModelFile::Open(output_path));
  info = model->info();
  return scene;
}

}  // namespace treeline::training
