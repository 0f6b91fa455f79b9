// From a structure from motion to a model file of method sift.
#ifndef SERVER_CORE_TRAINING_SIFT_SCENE_TRAINER_H_
#define SERVER_CORE_TRAINING_SIFT_SCENE_TRAINER_H_

#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "server/core/training/scene_trainer.h"

namespace treeline::training {

// TrainScene for method sift: options.sift, and of options.forest seed,
// threads and trees. Errors as TrainScene and TrainSiftForest.
absl::StatusOr<TrainedScene> TrainSiftScene(const dataset::Dataset& dataset,
                                            const SceneTrainingOptions& options,
                                            const std::string& output_path,
                                            bool quiet,
                                            const std::stop_token& stop);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_SIFT_SCENE_TRAINER_H_
