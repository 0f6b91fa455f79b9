// Trained models in a folder, so that a comparison need not train twice.
#ifndef SERVER_TOOLS_MODEL_STORE_H_
#define SERVER_TOOLS_MODEL_STORE_H_

#include <optional>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/temporary_folder.h"
#include "common/dataset/dataset.h"
#include "server/core/training/scene_trainer.h"

namespace treeline::tools {

// What models are trained on and how, but for the method.
struct ModelStoreOptions {
  dataset::DatasetOptions dataset;
  // As --calibration has it: "auto", or the file that `calibration` is of.
  std::string calibration_name = "auto";
  std::optional<camera::RgbdCalibration> calibration;
  bool quiet = false;
  std::stop_token stop;
};

// A folder of models; a temporary one goes with the object.
class ModelStore {
 public:
  // folder: made where missing; empty: a temporary one.
  static absl::StatusOr<ModelStore> Open(const std::string& folder,
                                         ModelStoreOptions options);

  // The path of a model of this method and these options: the one that is
  // there if it is sound and was trained on a dataset of this name with the
  // same options by this version, else one trained now. Errors are those of
  // TrainScene.
  absl::StatusOr<std::string> Train(
      const dataset::Dataset& dataset, const std::string& method,
      const training::TrainingOptions& training) const;

  // DIR/NAME.treeline, for files of one's own.
  std::string PathOf(absl::string_view name) const;

 private:
  ModelStore(std::string folder, std::optional<base::TemporaryFolder> temporary,
             ModelStoreOptions options);

  std::string folder_;
  std::optional<base::TemporaryFolder> temporary_;  // which it is then
  ModelStoreOptions options_;
};

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_MODEL_STORE_H_
