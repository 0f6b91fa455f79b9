// What a model says about how it was trained.
#ifndef SERVER_TOOLS_TRAINING_RECORD_H_
#define SERVER_TOOLS_TRAINING_RECORD_H_

#include <string>
#include <utility>
#include <vector>

#include "common/dataset/dataset.h"
#include "server/core/training/sift_trainer.h"
#include "server/core/training/training_options.h"

namespace treeline::tools {

// Each flag of `treeline train` that shapes a model, without its dashes, and
// its value: ModelInfo::options. calibration: as --calibration has it;
// adapt, extend: as these flags have them.
std::vector<std::pair<std::string, std::string>> RecordedOptions(
    const dataset::DatasetOptions& dataset, const std::string& calibration,
    const training::TrainingOptions& training, const std::string& adapt = "",
    const std::string& extend = "");

// The same for method sift.
std::vector<std::pair<std::string, std::string>> RecordedSiftOptions(
    const dataset::DatasetOptions& dataset,
    const training::TrainingOptions& training,
    const training::SiftTrainingOptions& sift);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_TRAINING_RECORD_H_
