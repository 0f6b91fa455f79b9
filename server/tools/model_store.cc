#include "server/tools/model_store.h"

#include <stdlib.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "server/core/forest/model_file.h"
#include "server/tools/run_info.h"
#include "server/tools/training_record.h"

namespace treeline::tools {
namespace {

// "rgbd", "rgbd-balanced-levels-0": what differs from the defaults that the
// command line can change.
std::string ModelName(const std::string& method,
                      const training::TrainingOptions& training) {
  const training::TrainingOptions defaults;
  std::string name = method;
  if (training.balanced_levels != defaults.balanced_levels) {
    absl::StrAppend(&name, "-balanced-levels-", training.balanced_levels);
  }
  if (training.trees != defaults.trees) {
    absl::StrAppend(&name, "-trees-", training.trees);
  }
  return name;
}

bool IsSame(const forest::ModelInfo& info,
            const training::SceneTrainingOptions& wanted,
            const std::string& dataset_uri) {
  return info.method == wanted.method &&
         info.options == wanted.recorded_options &&
         info.seed == wanted.forest.seed && info.dataset == dataset_uri &&
         info.software_version == wanted.software_version;
}

}  // namespace

absl::StatusOr<ModelStore> ModelStore::Open(const std::string& folder,
                                            ModelStoreOptions options) {
  if (folder.empty()) {
    TL_ASSIGN_OR_RETURN(base::TemporaryFolder temporary,
                        base::TemporaryFolder::Make("treeline-models"));
    std::string path = temporary.path();
    return ModelStore(std::move(path), std::move(temporary),
                      std::move(options));
  }
  ModelStore store(folder, std::nullopt, std::move(options));
  const std::string some_file = store.PathOf("model");
  TL_RETURN_IF_ERROR(base::MakeParentFolder(some_file));
  TL_RETURN_IF_ERROR(base::CheckWritable(some_file));
  return store;
}

ModelStore::ModelStore(std::string folder,
                       std::optional<base::TemporaryFolder> temporary,
                       ModelStoreOptions options)
    : folder_(std::move(folder)),
      temporary_(std::move(temporary)),
      options_(std::move(options)) {}

std::string ModelStore::PathOf(absl::string_view name) const {
  return absl::StrCat(folder_, "/", name, ".treeline");
}

absl::StatusOr<std::string> ModelStore::Train(
    const dataset::Dataset& dataset, const std::string& method,
    const training::TrainingOptions& training) const {
  training::SceneTrainingOptions options;
  options.method = method;
  options.calibration = options_.calibration;
  if (options.calibration) {
    // The cameras are the file's; whose poses these are, the recording knows.
    options.calibration->pose_sensor = dataset.calibration().pose_sensor;
  }
  options.forest = training;
  options.software_version = base::Version();
  options.created_utc = UtcNow();
  options.recorded_options =
      method == "sift"
          ? RecordedSiftOptions(options_.dataset, training, options.sift)
          : RecordedOptions(options_.dataset, options_.calibration_name,
                            training);
  std::string path = PathOf(ModelName(method, training));
  if (std::filesystem::exists(path)) {
    const auto model = forest::ModelFile::Open(path);
    if (model.ok() && IsSame((*model)->info(), options, dataset.uri())) {
      if (!options_.quiet) {
        std::fprintf(stderr, "taking the model that is there: %s\n",
                     path.c_str());
      }
      return path;
    }
  }
  if (!options_.quiet) {
    std::fprintf(stderr, "training %s\n", path.c_str());
  }
  TL_RETURN_IF_ERROR(training::TrainScene(dataset, options, path,
                                          options_.quiet, options_.stop)
                         .status());
  return path;
}

}  // namespace treeline::tools
