// From a recording to a model file, for every method.
#ifndef SERVER_CORE_TRAINING_SCENE_TRAINER_H_
#define SERVER_CORE_TRAINING_SCENE_TRAINER_H_

#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/dataset/dataset.h"
#include "server/core/forest/model_info.h"
#include "server/core/training/confidence_fitter.h"
#include "server/core/training/forest_refiller.h"
#include "server/core/training/rgbd_calibrator.h"
#include "server/core/training/sift_trainer.h"
#include "server/core/training/training_options.h"

namespace treeline::training {

// The methods that can be trained, in the order of the documentation.
struct MethodDescription {
  const char* name;     // of --method, and of ModelInfo::method
  const char* summary;  // a line for --help
};
std::span<const MethodDescription> TrainableMethods();

struct SceneTrainingOptions {
  std::string method = "universal";
  // How depth and colour fit together: nullopt estimates it from the frames.
  std::optional<camera::RgbdCalibration> calibration;
  // Called with the estimate before learning begins; may be empty.
  std::function<void(const CalibrationReport&)> on_calibrated;
  TrainingOptions forest;
  // A model of the same method whose trees are kept and whose leaves are
  // refilled; empty: trees are grown. kAdapt: the model is of another scene;
  // kExtend: `dataset` adds frames to its scene, in the same world frame.
  std::string base_model;
  Refill refill = Refill::kAdapt;
  // Writes a base for kAdapt: splits without what the leaves learnt.
  bool splits_only = false;
  // Of method sift; seed, threads and trees are those of `forest`.
  SiftTrainingOptions sift;
  // See ConfidenceOptions; may be empty.
  std::function<void(std::span<const ConfidenceTrial>)> on_trials;
  // What the model records about where it came from; see ModelInfo.
  std::string software_version;
  std::string created_utc;
  std::vector<std::pair<std::string, std::string>> recorded_options;
};

struct TrainedScene {
  forest::ModelInfo info;  // as read back from the file
};

// Trains `dataset` with a method and writes the model to output_path,
// atomically; the file is read back as a server will. INVALID_ARGUMENT: an
// unknown method or bad options; FAILED_PRECONDITION: the dataset lacks what
// the method needs; CANCELLED after `stop`; and whatever reading a frame gives.
absl::StatusOr<TrainedScene> TrainScene(const dataset::Dataset& dataset,
                                        const SceneTrainingOptions& options,
                                        const std::string& output_path,
                                        bool quiet,
                                        const std::stop_token& stop);

// The same by many machines. Each grows one tree, in [0, options.forest.trees),
// and writes it to output_path; options are those of TrainScene, without
// base_model and splits_only. Errors as TrainScene; INVALID_ARGUMENT for such a
// tree or for method sift, whose trees are grown together.
absl::StatusOr<TrainedScene> TrainTree(const dataset::Dataset& dataset,
                                       const SceneTrainingOptions& options,
                                       int tree, const std::string& output_path,
                                       bool quiet, const std::stop_token& stop);

// Makes the scene of all its parts: the same file, to the bit, that TrainScene
// would have written, but for created_utc and training_s (of which the latter
// is the longest part's and that of merging). `dataset` has the frames that the
// parts were grown from. Of `options`, software_version, created_utc, on_trials
// and forest.threads count; the others are the parts'. Errors as TrainScene and
// ReadTreeParts; INVALID_ARGUMENT if the dataset has other frames.
absl::StatusOr<TrainedScene> MergeScene(const dataset::Dataset& dataset,
                                        const std::vector<std::string>& parts,
                                        SceneTrainingOptions options,
                                        const std::string& output_path,
                                        bool quiet,
                                        const std::stop_token& stop);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_SCENE_TRAINER_H_
